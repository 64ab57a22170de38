//! Content of the served page: state and report of a folder.

use crate::{Page, PageBlock, ReportOptions, Section, holds_results, report};
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::UNIX_EPOCH;

/// Maximum depth of subfolders that are scanned, that of the records of a data set.
const DEPTH: usize = 3;
/// Folder of frames for ParaView, which the page does not show.
const FRAMES: &str = "frames";

/// Page of a folder.
#[derive(Debug)]
pub struct Content {
    dir: PathBuf,
    wishes: ReportOptions,
    /// State, and the page generated for it.
    made: Mutex<(String, String)>,
}

impl Content {
    /// Creates the content of a folder, which need not exist yet.
    pub fn new(dir: PathBuf, wishes: ReportOptions) -> Self {
        Self { dir, wishes, made: Mutex::default() }
    }

    /// Returns a hash (hexadecimal) of the names, sizes and modification times of all files of the folder.
    pub fn state(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hash_folder(&self.dir, DEPTH, &mut hasher);
        hasher.finalize().to_hex()[..16].into()
    }

    /// Returns the page, which is generated once per state.
    pub fn page(&self) -> String {
        // Computed before the files are read, so that a concurrent write results in another state.
        let state = self.state();
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if made.0 != state {
            *made = (state.clone(), self.generate(&state));
        }
        made.1.clone()
    }

    fn generate(&self, state: &str) -> String {
        let note = match holds_results(&self.dir) {
            false => "There are no results yet; the page shows them as soon as they are written.".into(),
            true => match report(std::slice::from_ref(&self.dir), &self.wishes).and_then(|page| page.live(state)) {
                Ok(page) => return page,
                Err(error) => error.to_string(),
            },
        };
        let title = self.dir.file_name().unwrap_or(self.dir.as_os_str()).to_string_lossy();
        let section = Section::new(title, "", vec![PageBlock::Note(note)]);
        let page = Page { sections: vec![section], ..Page::default() };
        // Generating a page without recordings cannot fail.
        page.live(state).unwrap_or_default()
    }
}

/// Hashes name, size and modification time of all files in a folder, sorted by name.
fn hash_folder(dir: &Path, depth: usize, hasher: &mut blake3::Hasher) {
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
    // Entries without readable metadata (e.g. just removed) are skipped.
    let mut found: Vec<_> = entries.filter_map(|entry| Some((entry.file_name(), entry.metadata().ok()?))).collect();
    found.sort_by(|a, b| a.0.cmp(&b.0));
    for (name, meta) in found {
        hasher.update(name.as_encoded_bytes());
        if !meta.is_dir() {
            hasher.update(&meta.len().to_le_bytes()).update(&date(&meta).to_le_bytes());
        } else if depth > 1 && name != FRAMES {
            hash_folder(&dir.join(name), depth - 1, hasher);
        }
    }
}

/// Returns the modification time, ns since 1970-01-01 UTC.
fn date(meta: &Metadata) -> u128 {
    let since = meta.modified().ok().and_then(|date| date.duration_since(UNIX_EPOCH).ok());
    since.map_or(0, |since| since.as_nanos())
}
