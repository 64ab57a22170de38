//! Records of the finished grasps: one small file each, written atomically after the rows of the grasp.

use base::error::{Error, Result};
use base::files::atomic::{create_dir, write_durable};
use model::evaluation::Verdict;
use record::Status;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Record of a finished grasp.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FinishedGrasp {
    /// Number of the grasp, from 0.
    pub grasp: usize,
    /// Status at the end of the grasp.
    pub status: Status,
    /// Reason if the load was not reached.
    pub reason: Option<String>,
    /// Number of recorded frames.
    pub frames: usize,
    /// BLAKE3 of the rows, hexadecimal.
    pub checksum: String,
    /// Verdicts on the expectations of the scene about the frames; empty if there are none.
    #[serde(default)]
    #[serde(rename = "promises")]
    pub expectations: Vec<Verdict>,
}

/// Name of the record of the layout.
const LAYOUT: &str = "layout";

/// Records of one object.
#[derive(Debug, Clone)]
pub struct ProgressRecords {
    dir: PathBuf,
}

impl ProgressRecords {
    /// Returns the records stored in `dir`.
    pub fn of(dir: PathBuf) -> Self {
        Self { dir }
    }

    /// Writes the record of a grasp.
    ///
    /// # Errors
    /// Fails if the record cannot be written.
    pub fn record_grasp(&self, finished: &FinishedGrasp) -> Result<()> {
        let path = self.path(finished.grasp);
        let text = serde_json::to_string(finished).map_err(|e| Error::file(&path, e.to_string()))?;
        write_durable(&path, format!("{text}\n{}\n", blake3::hash(text.as_bytes()).to_hex()).as_bytes())
    }

    /// Returns the finished grasps with numbers below `count`. A record that cannot be read or was changed is ignored,
    /// so that its grasp runs again.
    pub fn finished(&self, count: usize) -> BTreeMap<usize, FinishedGrasp> {
        let read = |grasp: usize| {
            let content = std::fs::read_to_string(self.path(grasp)).ok()?;
            let (text, hash) = content.strip_suffix('\n')?.rsplit_once('\n')?;
            let sound = blake3::hash(text.as_bytes()).to_hex().as_str() == hash;
            let record: FinishedGrasp = serde_json::from_str(Some(text).filter(|_| sound)?).ok()?;
            (record.grasp == grasp).then_some((grasp, record))
        };
        (0..count).filter_map(read).collect()
    }

    /// Removes all records and creates the empty folder.
    ///
    /// # Errors
    /// Fails if the folder cannot be removed or created.
    pub fn clear(&self) -> Result<()> {
        remove(&self.dir)?;
        create_dir(&self.dir)
    }

    /// Writes the record of the layout for the rows of all grasps.
    ///
    /// # Errors
    /// Fails if the record cannot be written.
    pub fn record_layout(&self, layout: &str) -> Result<()> {
        write_durable(&self.dir.join(LAYOUT), layout.as_bytes())
    }

    /// Returns the record of the layout; None if there is none.
    pub fn layout(&self) -> Option<String> {
        std::fs::read_to_string(self.dir.join(LAYOUT)).ok()
    }

    fn path(&self, grasp: usize) -> PathBuf {
        self.dir.join(format!("{grasp:06}.json"))
    }
}

/// Removes a folder with its content, if it exists.
///
/// # Errors
/// Fails if the folder exists and cannot be removed.
pub fn remove(dir: &Path) -> Result<()> {
    match std::fs::remove_dir_all(dir) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::file(dir, format!("cannot be removed: {e}; remove it by hand")))
        }
        _ => Ok(()),
    }
}
