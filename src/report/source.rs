//! Kinds of results in a folder.

use crate::error::{Error, Result};
use std::path::{Path, PathBuf};

/// Choice of the results that are shown.
#[derive(Debug, Clone)]
pub struct Wishes {
    /// Folder of a trained model that is judged on the data sets.
    pub model: Option<PathBuf>,
    /// Split of the data sets; the default is that of the model, otherwise `poses`.
    pub split: Option<String>,
    /// Number of grasps of each folder in 3-D.
    pub grasps: usize,
    /// Largest number of frames of each, spread over it and including the last.
    pub frames: usize,
}

/// Results in a folder.
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
}

/// File that reveals the kind of results in a folder.
type Mark = (&'static str, fn(PathBuf) -> Source);

const MARKS: [Mark; 4] = [
    ("bench.json", Source::Bench),
    ("sizes.json", Source::Sizes),
    ("manifest.json", Source::Data),
    ("run.json", Source::Run),
];

/// Returns all results in `dir`, at least one.
///
/// # Errors
/// Fails if the folder has none.
pub fn sources(dir: &Path) -> Result<Vec<Source>> {
    let found = MARKS.iter().filter(|(name, _)| dir.join(name).is_file());
    let found: Vec<Source> = found.map(|(_, source)| source(dir.to_path_buf())).collect();
    if found.is_empty() {
        let message = "holds no results; a report is of a folder that `tactus bench`, `run` or `dataset` wrote with -o \
                       (bench.json, sizes.json, run.json or manifest.json in it)";
        return Err(Error::file(dir, message));
    }
    Ok(found)
}
