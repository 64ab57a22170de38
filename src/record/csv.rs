//! `frames.csv`: one row of numbers per frame, written as soon as the frame is recorded.

use super::ErrorBound;
use super::frame::{Frame, pad_name};
use super::names;
use base::error::Result;
use base::files::atomic::cannot_write;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Open `frames.csv`.
#[derive(Debug)]
pub struct FramesCsv {
    path: PathBuf,
    file: File,
}

impl FramesCsv {
    /// Creates the file and its header for grasps with `pads` pads; `moving` adds the columns of dynamic scenes,
    /// `predicted` those of the error bound.
    ///
    /// # Errors
    /// Fails if the file cannot be created or written.
    pub fn create(path: &Path, pads: usize, moving: bool, predicted: bool) -> Result<Self> {
        let file = File::create(path).map_err(|e| cannot_write(path, &e))?;
        let mut csv = FramesCsv { path: path.to_path_buf(), file };
        csv.line(&columns(pads, moving, predicted).join(","))?;
        Ok(csv)
    }

    /// Appends the row of `frame`.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn push(&mut self, frame: &Frame) -> Result<()> {
        self.line(&row(frame).join(","))
    }

    /// Writes a line unbuffered in one call, so that the file of a killed run ends with a complete row.
    fn line(&mut self, text: &str) -> Result<()> {
        self.file.write_all(format!("{text}\n").as_bytes()).map_err(|e| cannot_write(&self.path, &e))
    }
}

/// Returns the column names, with units as suffix (none for dimensionless columns).
pub fn columns(pads: usize, moving: bool, predicted: bool) -> Vec<String> {
    let mut columns: Vec<String> = ["frame", names::TIME, names::FORCE].map(String::from).to_vec();
    columns.extend((0..pads).map(|pad| format!("travel_{}_m", pad_name(pad))));
    columns.extend(["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"].map(|part| format!("object_{part}")));
    for pad in (0..pads).map(pad_name) {
        columns.extend(["x", "y", "z"].map(|axis| format!("contact_force_{pad}_{axis}_n")));
        columns.extend(["x", "y", "z"].map(|axis| format!("contact_torque_{pad}_{axis}_n_m")));
        columns.push(format!("max_displacement_{pad}_m"));
        columns.push(format!("max_von_mises_{pad}_pa"));
    }
    let solver = [
        names::ENERGY,
        names::NEWTON_ITERATIONS,
        names::MIN_DET_F,
        names::MIN_GAP,
        names::FORCE_BALANCE,
        names::TORQUE_BALANCE,
        names::RESIDUAL,
    ];
    columns.extend(solver.map(String::from));
    if moving {
        columns.extend(["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"].map(|part| format!("hand_{part}")));
        let vectors = [("velocity", "m_s"), ("spin", "rad_s"), ("momentum", "kg_m_s"), ("angular_momentum", "kg_m2_s")];
        for (name, unit) in vectors.into_iter().chain([("ground_force", "n")]) {
            columns.extend(["x", "y", "z"].map(|axis| format!("{name}_{axis}_{unit}")));
        }
    }
    if predicted {
        columns.extend(ErrorBound::NAMES.map(String::from));
    }
    columns
}

fn row(frame: &Frame) -> Vec<String> {
    let mut numbers = vec![frame.time, frame.applied_force];
    numbers.extend(&frame.travel);
    let q = frame.object_rotation;
    numbers.extend(frame.object_position.to_array());
    numbers.extend([q.w, q.x, q.y, q.z]);
    for pad in &frame.pads {
        numbers.extend(pad.wrench.row());
        numbers.push(pad.displacement.iter().map(|u| u.length()).fold(0.0, f64::max));
        // NaN gives an empty cell if stress is not recorded.
        numbers.push(pad.von_mises_node.iter().copied().reduce(f64::max).unwrap_or(f64::NAN));
    }
    numbers.push(frame.energy);
    let rest = [frame.min_det_f, frame.min_gap, frame.force_balance, frame.torque_balance, frame.residual];
    let before = std::iter::once(frame.index.to_string()).chain(numbers.into_iter().map(number));
    let moving = frame.moving.iter().flat_map(|m| {
        let (q, vectors) = (m.hand_rotation, [m.velocity, m.spin, m.momentum, m.angular_momentum, m.ground_force]);
        let pose = m.hand_position.to_array().into_iter().chain([q.w, q.x, q.y, q.z]);
        pose.chain(vectors.into_iter().flat_map(|v| v.to_array()))
    });
    let solver = [frame.newton_iterations.to_string()].into_iter().chain(rest.map(number));
    let error = frame.error.iter().flat_map(|error| error.to_array());
    before.chain(solver).chain(moving.chain(error).map(number)).collect()
}

/// Returns the shortest text that parses to the same number, in scientific notation outside 1e-3 to 1e6; empty for NaN
/// and infinity.
fn number(value: f64) -> String {
    if !value.is_finite() {
        return String::new();
    }
    let size = value.abs();
    if value == 0.0 || (1e-3..1e6).contains(&size) { value.to_string() } else { format!("{value:e}") }
}
