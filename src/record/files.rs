//! Files that are either complete or absent, and errors that say what to do.

use crate::error::{Error, Result};
use std::io::{self, ErrorKind};
use std::path::Path;

/// Writes `bytes` to `path` so that a reader, or a run killed half-way, sees the old content or the new, never a part.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<()> {
    replace(path, |temporary| std::fs::write(temporary, bytes))
}

/// Lets `write` fill a temporary file beside `path` and renames it into place.
pub fn replace(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> Result<()> {
    // Beside the target, not in /tmp: a rename is atomic only within one file system.
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".part");
    let temporary = path.with_file_name(name);
    let outcome = write(&temporary).and_then(|()| std::fs::rename(&temporary, path));
    outcome.map_err(|error| {
        // The half-written file is of no use, and may be what filled the disk; the first error is the one to report.
        let _ = std::fs::remove_file(&temporary);
        cannot_write(path, &error)
    })
}

/// Creates `dir` and its parents.
pub fn create_dir(dir: &Path) -> Result<()> {
    std::fs::create_dir_all(dir).map_err(|error| cannot_write(dir, &error))
}

/// An [`Error::File`] for a failed write with the likely remedy.
pub fn cannot_write(path: &Path, error: &io::Error) -> Error {
    let remedy = match error.kind() {
        ErrorKind::PermissionDenied => {
            "you may not write there; choose another output directory or change its permissions"
        }
        ErrorKind::ReadOnlyFilesystem => "the file system is mounted read-only; choose another output directory",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "the disk or your quota is full; free space, record fewer frames, or switch off the vtu files or arrays"
        }
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            "a file stands where a directory is needed; choose another output directory or move it away"
        }
        ErrorKind::NotFound => "its directory is gone; was the output directory removed during the run?",
        _ => "check the output directory",
    };
    Error::file(path, format!("cannot write: {error}; {remedy}"))
}
