//! Grasps finished so far: one small file each, written whole or not at all, after the grasp's rows.

use crate::error::{Error, Result};
use crate::record::Status;
use crate::record::files::{create_dir, write_atomic};
use crate::scene::Held;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// How a finished grasp went.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finished {
    /// Number of the grasp, from 0.
    pub grasp: usize,
    /// How it ended.
    pub status: Status,
    /// Why it was not reached.
    pub reason: Option<String>,
    /// Frames recorded.
    pub frames: usize,
    /// BLAKE3 of its rows, hexadecimal.
    pub checksum: String,
    /// What the scene promises of its frames; nothing if it has none.
    #[serde(default)]
    pub promises: Vec<Held>,
}

/// The records of one object.
#[derive(Debug, Clone)]
pub struct Progress {
    dir: PathBuf,
}

impl Progress {
    /// Kept in `dir`.
    pub fn of(dir: PathBuf) -> Self {
        Self { dir }
    }

    /// Enters a grasp.
    pub fn enter(&self, finished: &Finished) -> Result<()> {
        let path = self.path(finished.grasp);
        let text = serde_json::to_string(finished).map_err(|e| Error::file(&path, e.to_string()))?;
        write_atomic(&path, text.as_bytes())
    }

    /// The grasps below `count` that are finished. A record that cannot be read does not count: its grasp runs again.
    pub fn finished(&self, count: usize) -> BTreeMap<usize, Finished> {
        let read = |grasp: usize| {
            let record: Finished = serde_json::from_slice(&std::fs::read(self.path(grasp)).ok()?).ok()?;
            (record.grasp == grasp).then_some((grasp, record))
        };
        (0..count).filter_map(read).collect()
    }

    /// Starts anew.
    pub fn clear(&self) -> Result<()> {
        remove(&self.dir)?;
        create_dir(&self.dir)
    }

    fn path(&self, grasp: usize) -> PathBuf {
        self.dir.join(format!("{grasp:06}.json"))
    }
}

/// Removes a folder and what is in it, if it is there.
pub fn remove(dir: &Path) -> Result<()> {
    match std::fs::remove_dir_all(dir) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
            Err(Error::file(dir, format!("cannot be removed: {e}; remove it by hand")))
        }
        _ => Ok(()),
    }
}
