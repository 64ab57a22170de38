//! Content of an unfinished data set: the records of its finished grasps, and the file with their rows.

use super::campaign::{PROGRESS, open};
use super::manifest::ObjectEntry;
use super::progress::{FinishedGrasp, ProgressRecords};
use super::reader::ObjectFile;
use base::error::Result;
use std::collections::BTreeMap;
use std::path::Path;

/// Returns the finished grasps of an object of the data set in `dir`.
pub fn finished(dir: &Path, object: &ObjectEntry) -> BTreeMap<usize, FinishedGrasp> {
    ProgressRecords::of(dir.join(PROGRESS).join(&object.name)).finished(object.grasps)
}

/// Opens the file of an object under its final or its temporary name; rows of unfinished grasps fail their checksum.
///
/// # Errors
/// Fails as [`ObjectFile::open`] does.
pub fn file(dir: &Path, object: &ObjectEntry) -> Result<ObjectFile> {
    let path = dir.join(&object.file);
    ObjectFile::open(&if path.exists() { path } else { open(&path) })
}
