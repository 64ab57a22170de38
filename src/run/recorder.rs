//! The directory of a run: creates it, hands out grasps, keeps `run.json` current.

use super::grasp_files::GraspRecorder;
use crate::error::{Error, Result};
use crate::files::atomic::{cannot_write, write_durable};
use crate::files::lock::FolderLock;
use crate::geometry::mesh::TriMesh;
use crate::gripper::GraspPose;
use crate::record::frame::PadTopology;
use crate::record::meshes::{self, MESHES};
use crate::record::report::{ExpectationReport, GraspSummary, RunReport};
use crate::record::sensitivity::Moved;
use crate::render::Scalar;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Which files a run writes.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// `frames/*.vtu` and `run.pvd`.
    pub vtu: bool,
    /// `frames.csv`.
    pub csv: bool,
    /// `arrays.npz`.
    pub arrays: bool,
    /// Frames have a motion in time.
    pub moving: bool,
    /// `pads.png` of the last frame, coloured by this.
    pub picture: Option<Scalar>,
    /// `arrays.npz` is rewritten after this many frames: the most that a killed run can lose of it.
    pub flush_every: usize,
    /// Replace an earlier run in the same directory instead of refusing.
    pub overwrite: bool,
    /// Name of the object in the picture's title.
    pub object_name: String,
    /// Pose of each pad in the hand at zero travel: `x_hand = rotation * x_pad + position`; empty if not known.
    pub pads: Vec<GraspPose>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            vtu: true,
            csv: true,
            arrays: true,
            moving: false,
            picture: Some(Scalar::Stress),
            flush_every: 10,
            overwrite: false,
            object_name: "object".into(),
            pads: Vec::new(),
        }
    }
}

/// A run being recorded.
#[derive(Debug)]
pub struct RunRecorder {
    dir: PathBuf,
    options: Options,
    report: RunReport,
    grasps: BTreeMap<usize, GraspSummary>,
    _lock: FolderLock,
}

impl RunRecorder {
    /// Creates `dir`, holds it until the end, and writes a first `run.json`, so that a directory that cannot be written fails
    /// before anything is computed.
    ///
    /// # Errors
    /// A directory that another run is writing, that holds an earlier run, or that cannot be written.
    pub fn create(dir: &Path, options: Options, report: RunReport) -> Result<Self> {
        let lock = FolderLock::alone(dir, "tactus run")?;
        if dir.join("run.json").exists() {
            if !options.overwrite {
                let message = "holds an earlier run; choose another output directory, or allow to overwrite it";
                return Err(Error::file(dir, message));
            }
            remove_grasps(dir)?;
            remove_meshes(dir)?;
        }
        let recorder = RunRecorder { dir: dir.to_path_buf(), options, report, grasps: BTreeMap::new(), _lock: lock };
        recorder.report.write(&recorder.dir.join("run.json"))?;
        Ok(recorder)
    }

    /// The directory of the run.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// The report so far, e.g. to fill in the pads once they are meshed; written at the end of every grasp.
    pub fn report_mut(&mut self) -> &mut RunReport {
        &mut self.report
    }

    /// Starts recording grasp `index`, the first one with the meshes of the run; the grasp may move to another thread.
    pub fn begin_grasp(&self, index: usize, topologies: &[PadTopology], object: &TriMesh) -> Result<GraspRecorder> {
        if let Some(pad) = topologies.first().filter(|_| self.options.arrays && !self.dir.join(MESHES).exists()) {
            meshes::write(&self.dir, pad, object)?;
        }
        GraspRecorder::create(&self.dir, &self.options, index, topologies, object)
    }

    /// Completes the files of a grasp and enters its summary in `run.json`.
    pub fn end_grasp(&mut self, grasp: GraspRecorder, summary: GraspSummary) -> Result<()> {
        let index = grasp.index();
        // The summary first: it must not be lost to a picture that cannot be drawn.
        self.skip_grasp(index, summary)?;
        grasp.finish()
    }

    /// Enters the summary of a grasp that has no files (infeasible from the start).
    pub fn skip_grasp(&mut self, index: usize, mut summary: GraspSummary) -> Result<()> {
        summary.grasp = index;
        self.grasps.insert(index, summary);
        self.report.grasps = self.grasps.values().cloned().collect();
        self.report.write(&self.dir.join("run.json"))
    }

    /// Takes over what small changes do to the grasps, in order.
    pub fn add_sensitivity(&mut self, answers: Vec<Vec<Moved>>) {
        for (grasp, moved) in self.report.grasps.iter_mut().zip(answers) {
            grasp.sensitivity = moved;
        }
    }

    /// Writes the final `run.json` and hands the report back.
    pub fn finish(
        mut self,
        expectations: Vec<ExpectationReport>,
        profile_s: BTreeMap<String, f64>,
    ) -> Result<RunReport> {
        self.report.expectations = expectations;
        self.report.profile_s = profile_s;
        self.report.finished = true;
        let path = self.dir.join("run.json");
        let text = self.report.to_json().map_err(|message| Error::file(&path, format!("not written: {message}")))?;
        write_durable(&path, text.as_bytes())?;
        Ok(self.report)
    }
}

/// Removes the meshes of an earlier run.
fn remove_meshes(dir: &Path) -> Result<()> {
    let path = dir.join(MESHES);
    match std::fs::remove_file(&path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(cannot_write(&path, &e)),
        _ => Ok(()),
    }
}

/// Removes `grasp_<digits>` directories, nothing else: frames of two runs must not mix, and other files are not ours.
fn remove_grasps(dir: &Path) -> Result<()> {
    let entries = std::fs::read_dir(dir).map_err(|e| cannot_write(dir, &e))?;
    for entry in entries.flatten() {
        let name = entry.file_name();
        let digits = name.to_str().and_then(|n| n.strip_prefix("grasp_")).unwrap_or("");
        if !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) {
            std::fs::remove_dir_all(entry.path()).map_err(|e| cannot_write(&entry.path(), &e))?;
        }
    }
    Ok(())
}
