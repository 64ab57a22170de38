//! `manifest.json`: content, progress and failures of a data set.

use super::arrays::FORMAT;
use super::progress::FinishedGrasp;
use super::row_positions::RemainderChecksum;
use base::error::{Error, Result};
use base::files::atomic::write_durable;
use model::evaluation::Verdict;
use record::Status;
use scene::Name;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Content of `manifest.json`. It holds no times, so that equal data sets have equal manifests.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the layout.
    pub format: u64,
    /// BLAKE3 of this file with an empty checksum; empty in older data sets.
    #[serde(default)]
    pub checksum: String,
    /// Version of tactus.
    pub tactus: String,
    /// True once every grasp has run.
    pub finished: bool,
    /// Description of the scene.
    pub about: String,
    /// BLAKE3 of everything that determines the content: scenes, grasps, splits, version of tactus. A data set with
    /// another plan is not resumed.
    pub plan: String,
    /// Number of grasps of all objects.
    pub grasps: usize,
    /// Number of frames of a grasp.
    pub frames: usize,
    /// Size of all object files, bytes.
    pub bytes: u64,
    /// BLAKE3 of `splits.json`; empty until the data set is finished.
    #[serde(default)]
    pub splits: String,
    /// Entries of the objects.
    pub objects: Vec<ObjectEntry>,
    /// Randomly drawn objects that are excluded from the data set.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<ExcludedObject>,
}

/// Randomly drawn object that is excluded, for example because no grasp was found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ExcludedObject {
    /// Name of the object.
    pub name: String,
    /// Reason why it is excluded.
    pub reason: String,
}

impl ExcludedObject {
    pub(super) fn new(name: &Name, error: &Error) -> Self {
        let text = error.to_string();
        Self { name: name.as_str().into(), reason: text.strip_prefix("error: ").unwrap_or(&text).into() }
    }
}

/// Entry of an object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ObjectEntry {
    /// Name of the object.
    pub name: String,
    /// Path of its file, relative to the folder of the data set.
    pub file: PathBuf,
    /// Number of its grasps.
    pub grasps: usize,
    /// Size of its file, bytes; 0 until it is finished.
    pub bytes: u64,
    /// BLAKE3 of its file; empty until it is finished.
    pub blake3: String,
    /// Seal that detects damage to the file without reading all of it; None until it is finished.
    #[serde(default)]
    pub seal: Option<RemainderChecksum>,
    /// Number of grasps that reached their load.
    pub reached: usize,
    /// Number of grasps that dropped the object.
    #[serde(default)]
    pub dropped: usize,
    /// Number of grasps that the solver could not complete.
    pub fault: usize,
    /// Number of grasps that could not start.
    pub infeasible: usize,
    /// Notices: how the grasps were found, and assumptions and repairs.
    pub notices: Vec<String>,
    /// Grasps that did not reach their load, with the reason.
    pub failures: Vec<FailedGrasp>,
    /// Verdicts on the expectations of the scene over all recorded frames.
    #[serde(default)]
    #[serde(rename = "promises")]
    pub expectations: Vec<ExpectationOutcome>,
}

/// Verdict on an expectation of the scene over the frames of all grasps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExpectationOutcome {
    /// Verdict on the worst grasp.
    pub worst: Verdict,
    /// Numbers of the grasps that violate the expectation.
    pub broken_by: Vec<usize>,
}

/// Grasp that did not reach its load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FailedGrasp {
    /// Number of the grasp, from 0.
    pub grasp: usize,
    /// Status at the end of the grasp.
    pub status: Status,
    /// Reason of this status.
    pub reason: String,
    /// Number of valid frames, which are the first ones.
    pub frames: usize,
}

/// Name of the file.
pub const MANIFEST_NAME: &str = "manifest.json";

impl Manifest {
    /// Reads the manifest of a data set; returns None if there is none.
    ///
    /// # Errors
    /// Fails if the file is not a manifest, was changed or has another version of the layout.
    pub fn read(dir: &Path) -> Result<Option<Self>> {
        let path = dir.join(MANIFEST_NAME);
        let fail = |message: String| Error::file(&path, message);
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(fail(format!("cannot be read: {e}"))),
        };
        let text =
            String::from_utf8(bytes).map_err(|_| fail("is not a manifest of a data set: it is not UTF-8".into()))?;
        let manifest: Self = serde_json::from_str(&text).map_err(|e| {
            fail(format!(
                "is not a manifest of a data set: {e}; restore it from a copy, or generate the data set again in \
                 another folder"
            ))
        })?;
        let sum = &manifest.checksum;
        // The checksum of an unfinished manifest is not needed: only its plan is used, to resume the run.
        if manifest.finished
            && !sum.is_empty()
            && blake3::hash(text.replacen(sum, "", 1).as_bytes()).to_hex().as_str() != sum
        {
            let message =
                "was changed or damaged since it was written; restore it from a copy, or generate the data set again";
            return Err(fail(message.into()));
        }
        if manifest.format != FORMAT {
            return Err(fail(format!(
                "has layout {}; this build reads {FORMAT}: generate the data set again with `tactus dataset SCENE -o \
                 DIR` in another folder; models trained on it stay valid",
                manifest.format
            )));
        }
        Ok(Some(manifest))
    }

    /// Sets the checksum and writes the manifest atomically.
    ///
    /// # Errors
    /// Fails if the manifest cannot be serialised or the file cannot be written.
    pub fn write(&mut self, dir: &Path) -> Result<()> {
        let path = dir.join(MANIFEST_NAME);
        let text = |own: &Self| {
            let text = serde_json::to_string_pretty(own).map_err(|e| Error::file(&path, e.to_string()))?;
            Ok::<_, Error>(text + "\n")
        };
        self.checksum.clear();
        self.checksum = blake3::hash(text(self)?.as_bytes()).to_hex().to_string();
        write_durable(&path, text(self)?.as_bytes())
    }

    /// Returns the sum of a count over the objects.
    pub fn sum(&self, count: impl Fn(&ObjectEntry) -> usize) -> usize {
        self.objects.iter().map(count).sum()
    }
}

impl ObjectEntry {
    /// Adds the results of finished grasps.
    pub fn add_results<'a>(&mut self, finished: impl IntoIterator<Item = &'a FinishedGrasp>) {
        for f in finished {
            match f.status {
                Status::Reached => self.reached += 1,
                Status::Dropped => self.dropped += 1,
                Status::Fault => self.fault += 1,
                Status::Infeasible => self.infeasible += 1,
            }
            if f.status != Status::Reached {
                let reason = f.reason.clone().unwrap_or_default();
                self.failures.push(FailedGrasp { grasp: f.grasp, status: f.status, reason, frames: f.frames });
            }
            f.expectations.iter().for_each(|held| self.add(f.grasp, held));
        }
    }
    /// Adds the verdict on a grasp for one expectation.
    fn add(&mut self, grasp: usize, held: &Verdict) {
        let broken = (!held.held).then_some(grasp);
        match self.expectations.iter_mut().find(|p| p.worst.name == held.name) {
            Some(known) => {
                known.worst = known.worst.clone().worse_of(held.clone());
                known.broken_by.extend(broken);
            }
            None => {
                self.expectations.push(ExpectationOutcome { worst: held.clone(), broken_by: Vec::from_iter(broken) })
            }
        }
    }
}
