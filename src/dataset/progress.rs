//! Grasps finished so far: one small file each, written whole or not at all, after the grasp's rows.

use crate::error::{Error, Result};
use crate::files::atomic::{create_dir, write_durable};
use crate::judge::Held;
use crate::record::Status;
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

/// Name of the record of what was laid out.
const LAYOUT: &str = "layout";

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
        write_durable(&path, format!("{text}\n{}\n", blake3::hash(text.as_bytes()).to_hex()).as_bytes())
    }

    /// The grasps below `count` that are finished. A record that cannot be read, or is not what was written, does not count: its
    /// grasp runs again.
    pub fn finished(&self, count: usize) -> BTreeMap<usize, Finished> {
        let read = |grasp: usize| {
            let content = std::fs::read_to_string(self.path(grasp)).ok()?;
            let (text, hash) = content.strip_suffix('\n')?.rsplit_once('\n')?;
            let sound = blake3::hash(text.as_bytes()).to_hex().as_str() == hash;
            let record: Finished = serde_json::from_str(Some(text).filter(|_| sound)?).ok()?;
            (record.grasp == grasp).then_some((grasp, record))
        };
        (0..count).filter_map(read).collect()
    }

    /// Starts anew.
    pub fn clear(&self) -> Result<()> {
        remove(&self.dir)?;
        create_dir(&self.dir)
    }

    /// Enters what was laid out for the rows of all grasps.
    pub fn enter_layout(&self, layout: &str) -> Result<()> {
        write_durable(&self.dir.join(LAYOUT), layout.as_bytes())
    }

    /// What was laid out; None if that is not known.
    pub fn layout(&self) -> Option<String> {
        std::fs::read_to_string(self.dir.join(LAYOUT)).ok()
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
