//! Reader of data sets, one grasp at a time: only requested data is held in memory.

use super::manifest::{Manifest, ObjectEntry};
use super::reader::ObjectFile;
use super::rows::code;
use super::split::{GraspNumbers, Splits};
use base::error::{Error, Result};
use record::Status;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Data set on disk.
#[derive(Debug)]
pub struct DataSet {
    /// Folder of the data set.
    pub dir: PathBuf,
    /// Manifest of the data set.
    pub manifest: Manifest,
    /// Training and test sets.
    pub splits: Splits,
    /// Objects whose files are intact, in the order of the scene.
    pub objects: Vec<ObjectFile>,
    /// Errors of the rejected files; the rest is usable.
    pub damaged: Vec<Error>,
}

impl DataSet {
    /// Opens a finished data set and checks everything except the rows of grasps, which are checked when they are read.
    /// Damaged object files are listed and are not an error.
    ///
    /// # Errors
    /// Fails if there is no manifest, the data set is unfinished, or the manifest or the splits are unreadable or were
    /// changed.
    pub fn open(dir: impl AsRef<Path>) -> Result<Self> {
        let dir = dir.as_ref();
        let manifest = Manifest::read(dir)?.ok_or_else(|| {
            let message = "contains no data set (no manifest.json); generate one with `tactus dataset SCENE -o DIR`";
            match dir.exists() {
                true => Error::file(dir, message),
                false => Error::system(dir, message, ErrorKind::NotFound),
            }
        })?;
        if !manifest.finished {
            return Err(Error::file(
                dir,
                "the data set is not finished; run the same `tactus dataset` command again to resume",
            ));
        }
        let path = dir.join("splits.json");
        let bytes = std::fs::read(&path).map_err(|e| Error::system(&path, format!("cannot be read: {e}"), e.kind()))?;
        if !manifest.splits.is_empty() && blake3::hash(&bytes).to_hex().as_str() != manifest.splits {
            return Err(Error::file(&path, "was changed or damaged since it was written; restore it from a copy"));
        }
        let splits = serde_json::from_slice(&bytes).map_err(|e| Error::file(&path, format!("is not readable: {e}")))?;
        let (mut objects, mut damaged) = (Vec::new(), Vec::new());
        for entry in &manifest.objects {
            match open_object(&dir.join(&entry.file), entry) {
                Ok(object) => objects.push(object),
                Err(error) => damaged.push(error),
            }
        }
        Ok(Self { dir: dir.to_path_buf(), manifest, splits, objects, damaged })
    }

    /// Returns every reached grasp that a split lists, as (index in [`Self::objects`], number of the grasp).
    pub fn select(&self, poses: &GraspNumbers) -> Vec<(usize, usize)> {
        self.with_status(poses, code(Status::Reached))
    }

    /// Returns every dropped grasp that a split lists, as [`Self::select`] does.
    pub fn select_dropped(&self, poses: &GraspNumbers) -> Vec<(usize, usize)> {
        self.with_status(poses, code(Status::Dropped))
    }

    fn with_status(&self, poses: &GraspNumbers, status: u8) -> Vec<(usize, usize)> {
        let of = |(index, object): (usize, &ObjectFile)| {
            let wanted = poses.get(&object.name).cloned().unwrap_or_default();
            let found = wanted.into_iter().filter(|g| object.status.get(*g) == Some(&status));
            found.map(|g| (index, g)).collect::<Vec<_>>()
        };
        self.objects.iter().enumerate().flat_map(of).collect()
    }
}

/// Opens the file of an object if it agrees with its entry.
fn open_object(path: &Path, entry: &ObjectEntry) -> Result<ObjectFile> {
    let fail = |message: String| Err(Error::file(path, message));
    let size =
        std::fs::metadata(path).map_err(|e| Error::system(path, format!("cannot be opened: {e}"), e.kind()))?.len();
    if size != entry.bytes {
        return fail(format!("has {size} bytes instead of {}: truncated or changed", entry.bytes));
    }
    // Older data sets have a hash of the whole file only.
    let same = entry.seal.as_ref().map_or_else(|| Ok(hash(path)? == entry.blake3), |seal| seal.matches(path))?;
    if !same {
        return fail(
            "was changed or damaged since it was generated: it is not the file of the manifest; restore it from a \
             copy, or generate the data set again"
                .into(),
        );
    }
    let object = ObjectFile::open(path)?;
    if object.name == entry.name && object.sizes.grasps == entry.grasps {
        Ok(object)
    } else {
        fail(format!(
            "contains {} grasps of `{}` instead of {} of `{}`",
            object.sizes.grasps, object.name, entry.grasps, entry.name
        ))
    }
}

/// Computes the BLAKE3 of a file, hexadecimal.
///
/// # Errors
/// Fails if the file cannot be read.
pub fn hash(path: &Path) -> Result<String> {
    let mut hasher = blake3::Hasher::new();
    let read = std::fs::File::open(path).and_then(|file| hasher.update_reader(file).map(|h| h.finalize()));
    let hash = read.map_err(|e| Error::system(path, format!("cannot be read: {e}"), e.kind()))?;
    Ok(hash.to_hex().to_string())
}
