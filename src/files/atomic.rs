//! Files that are either complete or absent, and errors that say what to do.

use crate::error::{Error, Result};
use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes `bytes` to `path` so that a reader, or a run killed half-way, sees the old content or the new, never a part.
///
/// # Errors
/// Fails if the file cannot be written.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<()> {
    replace(path, |temporary| std::fs::write(temporary, bytes))
}

/// Writes `bytes` like [`write_atomic`], with the content on the disk before the file has its name: see
/// [`replace_durable`].
///
/// # Errors
/// Fails if the file cannot be written.
pub fn write_durable(path: &Path, bytes: &[u8]) -> Result<()> {
    replace_durable(path, |temporary| std::fs::write(temporary, bytes))
}

/// Lets `write` fill a temporary file beside `path` and renames it into place.
///
/// A power cut may still lose the last content. That is acceptable for content that is quickly made again: frames for
/// ParaView, pictures, pages, the state of a run that goes on.
///
/// # Errors
/// Fails if `write` fails or the file cannot be created or renamed.
pub fn replace(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> Result<()> {
    place(path, write, false)
}

/// Replaces the file like [`replace`] and waits until content and name are on the disk: a power cut leaves the old
/// content or the new.
///
/// It is meant for content that took long to compute: the final `run.json`, arrays, data sets with their records,
/// checkpoints, trained models.
///
/// # Errors
/// Fails if `write` fails or the file cannot be created, synchronised or renamed.
pub fn replace_durable(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> Result<()> {
    place(path, write, true)
}

fn place(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>, durable: bool) -> Result<()> {
    let fill = |temporary: &Path| {
        write(temporary)?;
        if durable {
            OpenOptions::new().write(true).open(temporary)?.sync_all()?;
        }
        std::fs::rename(temporary, path)
    };
    let outcome = reserve(path).and_then(|temporary| {
        fill(&temporary).inspect_err(|_| {
            // The half-written file is of no use, and may be what filled the disk; the first error is the one to report.
            let _ = std::fs::remove_file(&temporary);
        })
    });
    if durable && outcome.is_ok() {
        sync_folder(path);
    }
    outcome.map_err(|error| cannot_write(path, &error))
}

/// Waits until the names in the folder of `path` are on the disk, if the system supports that.
pub fn sync_folder(path: &Path) {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Some systems and file systems do not sync folders; the content is safe all the same.
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// Ending of the names of temporary files.
const PART: &str = ".part";

/// Creates an empty file `.NAME.PROCESS.NUMBER.part` beside `path`, which no other process writes. It is beside it and
/// not in /tmp, because a rename is atomic only within one file system.
fn reserve(path: &Path) -> io::Result<PathBuf> {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    loop {
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let mut name = OsString::from(".");
        name.push(path.file_name().unwrap_or_default());
        name.push(format!(".{}.{number}{PART}", std::process::id()));
        let temporary = path.with_file_name(name);
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Ok(_) => return Ok(temporary),
            // Of a process of another machine, or of one that was killed.
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e),
        }
    }
}

/// Removes the temporary files that killed processes left in `dir`; only for the sole writer of the folder.
pub fn remove_left_over(dir: &Path) {
    let Ok(entries) = std::fs::read_dir(dir) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let fields = name.to_str().and_then(|n| n.strip_prefix('.')?.strip_suffix(PART));
        let mut numbers = fields.into_iter().flat_map(|f| f.rsplitn(3, '.').take(2));
        let number = |n: Option<&str>| n.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()));
        if number(numbers.next()) && number(numbers.next()) {
            // That it stays is not worth an error.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Creates `dir` and its parents.
///
/// # Errors
/// Fails if a folder cannot be created.
pub fn create_dir(dir: &Path) -> Result<()> {
    std::fs::create_dir_all(dir).map_err(|error| cannot_write(dir, &error))
}

/// Returns an [`Error::File`] for a failed write with the likely remedy.
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
    Error::system(path, format!("cannot write: {error}; {remedy}"), error.kind())
}
