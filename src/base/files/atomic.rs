//! Atomic writing of files, and error messages with remedies.

use crate::error::{Error, Result};
use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes `bytes` to `path` atomically: a reader, also after a crash, finds the old or the new content, never a part.
///
/// # Errors
/// Fails if the file cannot be written.
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<()> {
    replace(path, |temporary| std::fs::write(temporary, bytes))
}

/// Writes `bytes` like [`write_atomic`], and flushes the content to disk before the rename: see [`replace_durable`].
///
/// # Errors
/// Fails if the file cannot be written.
pub fn write_durable(path: &Path, bytes: &[u8]) -> Result<()> {
    replace_durable(path, |temporary| std::fs::write(temporary, bytes))
}

/// Calls `write` for a temporary file next to `path` and renames it to `path`.
///
/// A power failure may lose the last content, which is acceptable for content that is cheap to recreate: frames for
/// ParaView, pictures, pages, the state of a running run.
///
/// # Errors
/// Fails if `write` fails or the file cannot be created or renamed.
pub fn replace(path: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> Result<()> {
    place(path, write, false)
}

/// Replaces the file like [`replace`] and flushes content and name to disk: after a power failure the file has the old
/// or the new content.
///
/// Intended for content that is expensive to compute: the final `run.json`, arrays, data sets with their records,
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
            // The incomplete file may have filled the disk; the first error is the one to report.
            let _ = std::fs::remove_file(&temporary);
        })
    });
    if durable && outcome.is_ok() {
        sync_folder(path);
    }
    outcome.map_err(|error| cannot_write(path, &error))
}

/// Flushes the folder of `path` to disk if the system supports that.
pub fn sync_folder(path: &Path) {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Some systems and file systems cannot flush folders; the content is on disk nevertheless.
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// Extension of temporary files.
const PART: &str = ".part";

/// Creates an empty file `.NAME.PROCESS.NUMBER.part` in the folder of `path`, which no other process writes; not in
/// /tmp, because a rename is atomic only within one file system.
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
            // The name belongs to a process on another machine, or to one that was killed.
            Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
            Err(e) => return Err(e),
        }
    }
}

/// Removes temporary files of killed processes from `dir`; to be called only by the sole writer of the folder.
pub fn remove_temporary_files(dir: &Path) {
    let Ok(entries) = std::fs::read_dir(dir) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let fields = name.to_str().and_then(|n| n.strip_prefix('.')?.strip_suffix(PART));
        let mut numbers = fields.into_iter().flat_map(|f| f.rsplitn(3, '.').take(2));
        let number = |n: Option<&str>| n.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()));
        if number(numbers.next()) && number(numbers.next()) {
            // A file that cannot be removed is harmless.
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

/// Returns the error for a failed write, with a likely remedy.
pub fn cannot_write(path: &Path, error: &io::Error) -> Error {
    let remedy = match error.kind() {
        ErrorKind::PermissionDenied => {
            "writing there is not permitted; choose another output directory or change its permissions"
        }
        ErrorKind::ReadOnlyFilesystem => "the file system is mounted read-only; choose another output directory",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "the disk or your quota is full; free space, record fewer frames, or switch off the vtu files or arrays"
        }
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            "a file exists where a directory is needed; choose another output directory or move the file"
        }
        ErrorKind::NotFound => "its directory no longer exists; was the output directory removed during the run?",
        _ => "check the output directory",
    };
    Error::system(path, format!("cannot write: {error}; {remedy}"), error.kind())
}
