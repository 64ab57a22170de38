//! Detection of the kinds of results in a folder.

use base::error::{Error, Result};
use dataset::manifest::MANIFEST_NAME;
use net::train::curves::CURVES;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// Default maximum number of frames per grasp in 3-D.
pub const DEFAULT_FRAMES: usize = 25;

/// Options of a report.
#[derive(Debug, Clone)]
pub struct ReportOptions {
    /// Folder of a trained model to be evaluated on the data sets.
    pub model: Option<PathBuf>,
    /// Split of the data sets; None uses that of the model, or `poses` without a model.
    pub split: Option<String>,
    /// Number of grasps in 3-D per folder.
    pub grasps: usize,
    /// Maximum number of frames per grasp, spread evenly and including the last.
    pub frames: usize,
}

/// Kind of results, with their folder.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// Results of `tactus bench`.
    Bench(PathBuf),
    /// Results of `tactus bench --sizes`.
    Sizes(PathBuf),
    /// Results of `tactus run`.
    Run(PathBuf),
    /// Results of `tactus dataset`.
    Data(PathBuf),
    /// Results of `tactus train`.
    Training(PathBuf),
}

/// File name that identifies a kind of results.
type ResultFile = (&'static str, fn(PathBuf) -> Source);

const RESULT_FILES: [ResultFile; 5] = [
    ("bench.json", Source::Bench),
    ("sizes.json", Source::Sizes),
    (MANIFEST_NAME, Source::Data),
    ("run.json", Source::Run),
    (CURVES, Source::Training),
];

/// Returns all results in `dir`, or if there are none those in its subfolders, sorted by name: a run of several objects
/// has a subfolder for each.
///
/// # Errors
/// Fails if there are no results.
pub fn sources(dir: &Path) -> Result<Vec<Source>> {
    let own = in_folder(dir);
    if !own.is_empty() {
        return Ok(own);
    }
    let entries = std::fs::read_dir(dir).into_iter().flatten().flatten();
    let mut folders: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    folders.sort();
    let found: Vec<Source> = folders.iter().flat_map(|folder| in_folder(folder)).collect();
    if found.is_empty() {
        let message = "contains no results; a report needs a folder that `tactus run`, `dataset`, `train` or `bench` \
            wrote with -o (run.json, manifest.json, curves.csv, bench.json or sizes.json in it)";
        return Err(Error::file(dir, message));
    }
    Ok(found)
}

/// Returns true if there are results in `dir` or in one of its subfolders.
pub fn holds_results(dir: &Path) -> bool {
    sources(dir).is_ok()
}

fn in_folder(dir: &Path) -> Vec<Source> {
    let found = RESULT_FILES.iter().filter(|(name, _)| dir.join(name).is_file());
    found.map(|(_, source)| source(dir.to_path_buf())).collect()
}

impl Source {
    /// Returns the modification time of the identifying file, s since 1970-01-01 UTC.
    pub fn modified(&self) -> Option<u64> {
        let (Source::Bench(dir) | Source::Sizes(dir) | Source::Run(dir) | Source::Data(dir) | Source::Training(dir)) =
            self;
        let (name, _) = RESULT_FILES.iter().find(|(_, source)| source(dir.clone()) == *self)?;
        let date = std::fs::metadata(dir.join(name)).and_then(|meta| meta.modified()).ok()?;
        date.duration_since(UNIX_EPOCH).ok().map(|since| since.as_secs())
    }
}
