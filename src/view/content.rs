//! Content of the page: the state of a folder, and its report.

use crate::report::{Page, PageBlock, Section, Wishes, holds_results, report};
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::UNIX_EPOCH;

/// Depth to which a folder is looked through: records of a data set lie so deep.
const DEPTH: usize = 3;
/// Folder of the frames for ParaView, which the page does not show.
const FRAMES: &str = "frames";

/// Page of a folder.
#[derive(Debug)]
pub struct Content {
    dir: PathBuf,
    wishes: Wishes,
    /// State, and the page made of it.
    made: Mutex<(String, String)>,
}

impl Content {
    /// Returns the content of a folder, which need not be there yet.
    pub fn new(dir: PathBuf, wishes: Wishes) -> Self {
        Self { dir, wishes, made: Mutex::default() }
    }

    /// Returns the state of the folder, hexadecimal: another one wherever a file is.
    pub fn state(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        look(&self.dir, DEPTH, &mut hasher);
        hasher.finalize().to_hex()[..16].into()
    }

    /// Returns the page, made once for each state.
    pub fn page(&self) -> String {
        // Before the files are read: what is written meanwhile makes another state.
        let state = self.state();
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if made.0 != state {
            *made = (state.clone(), self.make(&state));
        }
        made.1.clone()
    }

    fn make(&self, state: &str) -> String {
        let note = match holds_results(&self.dir) {
            false => "Nothing is here yet: the page fills as the first results are written.".into(),
            true => match report(std::slice::from_ref(&self.dir), &self.wishes).and_then(|page| page.live(state)) {
                Ok(page) => return page,
                Err(error) => error.to_string(),
            },
        };
        let title = self.dir.file_name().unwrap_or(self.dir.as_os_str()).to_string_lossy();
        let section = Section::new(title, "", vec![PageBlock::Note(note)]);
        let page = Page { sections: vec![section], ..Page::default() };
        // A page without grasps cannot fail.
        page.live(state).unwrap_or_default()
    }
}

/// Takes in name, size and date of all files in a folder, sorted by name.
fn look(dir: &Path, depth: usize, hasher: &mut blake3::Hasher) {
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
    // Gone since it was listed, or hidden by the system: then there is nothing to show of it.
    let mut found: Vec<_> = entries.filter_map(|entry| Some((entry.file_name(), entry.metadata().ok()?))).collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    for (name, meta) in found {
        hasher.update(name.as_encoded_bytes());
        if !meta.is_dir() {
            hasher.update(&meta.len().to_le_bytes()).update(&date(&meta).to_le_bytes());
        } else if depth > 1 && name != FRAMES {
            look(&dir.join(name), depth - 1, hasher);
        }
    }
}

/// Returns the date of the last change, ns since 1970.
fn date(meta: &Metadata) -> u128 {
    let since = meta.modified().ok().and_then(|date| date.duration_since(UNIX_EPOCH).ok());
    since.map_or(0, |since| since.as_nanos())
}
