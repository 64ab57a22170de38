//! What a folder holds.

use crate::error::{Error, Result};
use std::path::{Path, PathBuf};

/// What is shown of it.
#[derive(Debug, Clone)]
pub struct Wishes {
    /// Folder of a trained model, to be judged on the data sets.
    pub model: Option<PathBuf>,
    /// Split of the data sets; that of the model by default, else `poses`.
    pub split: Option<String>,
    /// Grasps of each folder in 3-D.
    pub grasps: usize,
    /// At most so many frames of each, spread over it, the last one always.
    pub frames: usize,
}

/// Results in a folder.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// Of `tactus bench`.
    Bench(PathBuf),
    /// Of `tactus bench --sizes`.
    Sizes(PathBuf),
    /// Of `tactus run`.
    Run(PathBuf),
    /// Of `tactus dataset`.
    Data(PathBuf),
}

/// A file that tells what a folder holds.
type Mark = (&'static str, fn(PathBuf) -> Source);

const MARKS: [Mark; 4] = [
    ("bench.json", Source::Bench),
    ("sizes.json", Source::Sizes),
    ("manifest.json", Source::Data),
    ("run.json", Source::Run),
];

/// All results in `dir`, at least one.
///
/// # Errors
/// A folder without any.
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
