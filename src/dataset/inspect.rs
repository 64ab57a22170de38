//! Contents of a data set: counts, ranges, histograms, pictures.

use super::manifest::FailedGrasp;
use super::reader::{ObjectFile, StoredGrasp};
use super::set::{DataSet, hash};
use base::error::{Error, Result};
use geometry::Pose;
use geometry::Wrench;
use glam::DVec3;
use record::render::{self, Style};
use record::{Frame, PadFrame};
use serde::Serialize;
use std::path::Path;

/// Number of bars of a histogram.
pub const HISTOGRAM_BINS: usize = 20;

/// Selection of the grasps and frames that are inspected.
#[derive(Debug, Clone, Copy)]
pub struct InspectionSampling {
    /// Step between the inspected grasps of each object; 1 inspects all.
    pub every: usize,
    /// Largest number of inspected frames of a grasp, spread over it and including the last; None inspects all.
    pub frames: Option<usize>,
}

/// Result of an inspection.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// Summary of each object.
    pub objects: Vec<ObjectSummary>,
    /// Ranges over all objects.
    pub ranges: Vec<QuantityRange>,
    /// Files and grasps that are damaged, with the reason.
    pub damaged: Vec<String>,
}

/// Summary of an object.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ObjectSummary {
    /// Name of the object.
    pub name: String,
    /// Number of its grasps.
    pub grasps: usize,
    /// Number of grasps that reached their load.
    pub reached: usize,
    /// Grasps that did not reach their load, with reasons.
    pub failures: Vec<FailedGrasp>,
    /// Number of grasps that were inspected.
    pub read_grasps: usize,
    /// Number of frames that were inspected.
    pub read_frames: usize,
    /// Number of nodes of a pad, or of the larger one if the pads differ.
    pub nodes: usize,
    /// Number of tetrahedra of a pad, or of the larger one if the pads differ.
    pub tets: usize,
}

/// Range and histogram of a quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QuantityRange {
    /// Name of the quantity, with its unit at the end.
    pub name: &'static str,
    /// Smallest value.
    pub min: f64,
    /// Mean.
    pub mean: f64,
    /// Largest value.
    pub max: f64,
    /// Counts in [`HISTOGRAM_BINS`] equal intervals from min to max.
    pub histogram: Vec<usize>,
}

/// Quantities of a frame, by name.
const QUANTITIES: [&str; 6] =
    ["force_n", "travel_m", "max_displacement_m", "max_von_mises_pa", "max_contact_force_n", "object_motion_m"];

/// Inspects a data set; with `pictures`, draws the last inspected frame of each grasp into that folder.
///
/// # Errors
/// Fails if a picture cannot be written. Damaged data is reported in the result.
pub fn inspect(set: &DataSet, thinning: InspectionSampling, pictures: Option<&Path>) -> Result<Inspection> {
    let mut values = vec![Vec::new(); QUANTITIES.len()];
    let mut damaged: Vec<String> = set.damaged.iter().map(Error::to_string).collect();
    let mut objects = Vec::new();
    for file in &set.objects {
        let Some(entry) = set.manifest.objects.iter().find(|e| e.name == file.name) else { continue };
        let mut summary = ObjectSummary {
            name: file.name.clone(),
            grasps: file.sizes.grasps,
            reached: file.reached().count(),
            failures: entry.failures.clone(),
            read_grasps: 0,
            read_frames: 0,
            nodes: file.sizes.nodes,
            tets: file.pads.iter().map(|pad| pad.elements.len()).max().unwrap_or(0),
        };
        // The hash needs the whole file, so it is checked only if all grasps are inspected.
        let whole = thinning.every <= 1;
        let mut sound = true;
        for number in (0..file.sizes.grasps).step_by(thinning.every.max(1)) {
            let grasp = match file.grasp(number) {
                Ok(grasp) => grasp,
                Err(error) => {
                    sound = false;
                    damaged.push(error.to_string());
                    continue;
                }
            };
            let frames = sample_frames(grasp.frames, thinning.frames);
            summary.read_grasps += 1;
            summary.read_frames += frames.len();
            for &k in &frames {
                let of_frame = quantities(file, &grasp, k);
                values.iter_mut().zip(of_frame).for_each(|(all, value)| all.push(value));
            }
            if let (Some(dir), Some(&k)) = (pictures, frames.last()) {
                draw(file, &grasp, number, k, dir)?;
            }
        }
        if whole && sound && hash(&file.path)? != entry.blake3 {
            damaged.push(format!("{}: differs from the manifest outside the frames", file.path.display()));
        }
        objects.push(summary);
    }
    let ranges = QUANTITIES.iter().zip(&values).filter_map(|(name, v)| range(name, v)).collect();
    Ok(Inspection { objects, ranges, damaged })
}

/// Returns at most `most` of `frames` frames, evenly spread, including the last.
pub fn sample_frames(frames: usize, most: Option<usize>) -> Vec<usize> {
    let n = most.unwrap_or(frames).min(frames);
    (1..=n).map(|i| i * frames / n - 1).collect()
}

fn range(name: &'static str, values: &[f64]) -> Option<QuantityRange> {
    let (min, max) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    if values.is_empty() {
        return None;
    }
    let mut histogram = vec![0; HISTOGRAM_BINS];
    for v in values {
        let at = if max > min { (v - min) / (max - min) * HISTOGRAM_BINS as f64 } else { 0.0 };
        histogram[(at as usize).min(HISTOGRAM_BINS - 1)] += 1;
    }
    Some(QuantityRange { name, min, mean: values.iter().sum::<f64>() / values.len() as f64, max, histogram })
}

fn quantities(file: &ObjectFile, grasp: &StoredGrasp, k: usize) -> [f64; 6] {
    let s = &file.sizes;
    let longest = |all: &[f32]| {
        let frame = &all[k * s.pads * s.nodes * 3..(k + 1) * s.pads * s.nodes * 3];
        frame
            .as_chunks::<3>()
            .0
            .iter()
            .map(|v| v.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>())
            .fold(0.0, f64::max)
            .sqrt()
    };
    let stress = &grasp.von_mises[k * s.pads * s.nodes..(k + 1) * s.pads * s.nodes];
    let travel = &grasp.travel[k * s.pads..(k + 1) * s.pads];
    let place = |k: usize| DVec3::from_slice(&grasp.object_pose[7 * k..]);
    [
        grasp.force[k],
        travel.iter().sum::<f64>() / s.pads as f64,
        longest(&grasp.displacement),
        stress.iter().copied().fold(0.0, f32::max).into(),
        longest(&grasp.contact_force),
        place(k).distance(place(0)),
    ]
}

/// Draws a frame in the style of a run.
fn draw(file: &ObjectFile, grasp: &StoredGrasp, number: usize, k: usize, dir: &Path) -> Result<()> {
    let title = format!("{}, grasp {number:03}", file.name);
    let style = Style { title, ..Style::default() };
    let picture = render::render_pads(&file.pads, &frame(file, grasp, k), Some(&file.object), &style)?;
    render::save(&picture, &dir.join(format!("{}_{number:03}.png", file.name)))
}

/// Returns frame `k` of a grasp in the hand frame, as it was recorded.
pub fn frame(file: &ObjectFile, grasp: &StoredGrasp, k: usize) -> Frame {
    let s = &file.sizes;
    let vector = |v: &[f32; 3]| DVec3::from_array(v.map(f64::from));
    let pad = |i: usize| {
        let (at, pose, nodes) = (k * s.pads + i, &file.pad_poses[i], file.pads[i].rest.len());
        let vectors = |all: &[f32]| {
            let own = &all[3 * s.nodes * at..][..3 * nodes];
            own.as_chunks::<3>().0.iter().map(|v| pose.rotation * vector(v)).collect::<Vec<_>>()
        };
        let displacement = vectors(&grasp.displacement);
        let carried = pose.position + file.closing[i] * grasp.finger_position[at];
        let rest = file.pads[i].rest.iter().map(|x| pose.rotation * *x + carried);
        let wrench = &grasp.wrench[6 * at..6 * at + 6];
        PadFrame {
            position: rest.zip(&displacement).map(|(x, u)| x + *u).collect(),
            contact_force: vectors(&grasp.contact_force),
            von_mises_node: grasp.von_mises[s.nodes * at..][..nodes].iter().map(|v| f64::from(*v)).collect(),
            wrench: Wrench {
                force: pose.rotation * DVec3::from_slice(&wrench[..3]),
                torque: pose.rotation * DVec3::from_slice(&wrench[3..]),
            },
            displacement,
            ..PadFrame::default()
        }
    };
    let object = Pose::from_row(&grasp.object_pose[7 * k..]);
    Frame {
        index: k,
        applied_force: grasp.force[k],
        travel: grasp.travel[k * s.pads..(k + 1) * s.pads].to_vec(),
        object_position: object.position,
        object_rotation: object.rotation,
        pads: (0..s.pads).map(pad).collect(),
        ..Frame::default()
    }
}
