//! Directory of a run: creates it, starts the recorders of grasps, keeps `run.json` current.

use super::grasp_files::GraspRecorder;
pub use super::options::RecordingOptions;
use base::error::{Error, Result};
use base::files::atomic::{cannot_write, write_durable};
use base::files::lock::FolderLock;
use geometry::mesh::TriMesh;
use record::frame::PadTopology;
use record::meshes::{self, MESHES};
use record::report::{ExpectationReport, GraspSummary, RunReport};
use record::sensitivity::ChangeEffect;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Recorder of a run.
#[derive(Debug)]
pub struct RunRecorder {
    dir: PathBuf,
    options: RecordingOptions,
    report: RunReport,
    /// Summaries by position in the order and number of the grasp.
    grasps: BTreeMap<(usize, usize), GraspSummary>,
    lock: FolderLock,
}

impl RunRecorder {
    /// Creates `dir`, locks it until the end of the run, and writes an initial `run.json`, so that a directory that
    /// cannot be written fails before anything is computed.
    ///
    /// # Errors
    /// Fails if another run is writing to the directory, if it holds an earlier run, or if it cannot be written.
    pub fn create(dir: &Path, options: RecordingOptions, report: RunReport) -> Result<Self> {
        let lock = FolderLock::exclusive(dir, "tactus run")?;
        if dir.join("run.json").exists() {
            if !options.overwrite {
                let message = "contains an earlier run; choose another output directory, or allow to overwrite it";
                return Err(Error::file(dir, message));
            }
            remove_grasps(dir)?;
            remove_meshes(dir)?;
        }
        let recorder = RunRecorder { dir: dir.to_path_buf(), options, report, grasps: BTreeMap::new(), lock };
        recorder.report.write(&recorder.dir.join("run.json"))?;
        Ok(recorder)
    }

    /// Returns a notice for the user if the directory is held without a lock of the system.
    pub fn notice(&self) -> Option<String> {
        self.lock.notice()
    }

    /// Returns the directory of the run.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Returns the report so far, e.g. to add the pads once they are meshed; it is written at the end of every grasp.
    pub fn report_mut(&mut self) -> &mut RunReport {
        &mut self.report
    }

    /// Starts recording grasp `index`. The first grasp also writes the meshes of the run. The recorder may be sent to
    /// another thread.
    ///
    /// # Errors
    /// Fails if the meshes cannot be written, and as [`GraspRecorder::create`] does.
    pub fn begin_grasp(&self, index: usize, topologies: &[PadTopology], object: &TriMesh) -> Result<GraspRecorder> {
        if self.options.arrays && !topologies.is_empty() && !self.dir.join(MESHES).exists() {
            meshes::write(&self.dir, topologies, object)?;
        }
        GraspRecorder::create(&self.dir, &self.options, index, topologies, object)
    }

    /// Completes the files of a grasp and adds its summary to `run.json`.
    ///
    /// # Errors
    /// Fails if `run.json` or a file of the grasp cannot be written, or if its picture cannot be drawn.
    pub fn end_grasp(&mut self, grasp: GraspRecorder, summary: GraspSummary) -> Result<()> {
        let index = grasp.index();
        // The summary first: it must not be lost if the picture cannot be drawn.
        self.skip_grasp(index, summary)?;
        grasp.finish()
    }

    /// Adds the summary of a grasp that has no files (infeasible from the start).
    ///
    /// # Errors
    /// Fails if `run.json` cannot be written.
    pub fn skip_grasp(&mut self, index: usize, mut summary: GraspSummary) -> Result<()> {
        summary.grasp = index;
        let order = &self.options.order;
        let place = order.iter().position(|number| *number == index).unwrap_or(order.len());
        self.grasps.insert((place, index), summary);
        self.report.grasps = self.grasps.values().cloned().collect();
        self.report.write(&self.dir.join("run.json"))
    }

    /// Adds the sensitivities of the grasps, in order.
    pub fn add_sensitivity(&mut self, answers: Vec<Vec<ChangeEffect>>) {
        for (grasp, moved) in self.report.grasps.iter_mut().zip(answers) {
            grasp.sensitivity = moved;
        }
    }

    /// Writes the final `run.json` and returns the report.
    ///
    /// # Errors
    /// Fails if the report cannot be serialised or `run.json` cannot be written.
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

/// Removes only `grasp_<digits>` directories: frames of two runs must not mix, and other files are not of a run.
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
