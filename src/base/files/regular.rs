//! Reading of user-specified files: only regular files of limited size.
//!
//! Directories, fifos (which may block) and devices (which may not end) are rejected before they are opened.

use crate::error::{Error, Result};
use std::fs::{File, FileType, Metadata};
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Opens a regular file for reading.
///
/// # Errors
/// Fails if the file is missing or not readable, or if the path is a directory, fifo, device or socket.
pub fn open(path: &Path) -> Result<File> {
    checked(path).map(|(file, _)| file)
}

/// Reads all bytes of a regular file of at most `limit` bytes.
///
/// # Errors
/// Fails in the cases of [`open()`], for a larger file and on an I/O error.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let (file, meta) = checked(path)?;
    let too_large = |size: String| Error::file(path, format!("{size} bytes; at most {limit} are allowed"));
    if meta.len() > limit {
        return Err(too_large(meta.len().to_string()));
    }
    let mut bytes = Vec::new();
    // Reads one byte more than allowed to detect larger files: a file may grow meanwhile, and files in /proc report
    // size zero.
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(|e| failed(path, &e))?;
    if bytes.len() as u64 > limit {
        return Err(too_large(format!("more than {limit}")));
    }
    Ok(bytes)
}

/// Returns the kind of a file that is not regular, e.g. "a directory"; None for a regular file.
pub fn special_file_kind(meta: &Metadata) -> Option<&'static str> {
    let kind = meta.file_type();
    (!kind.is_file()).then(|| if kind.is_dir() { "a directory" } else { special(kind) })
}

/// Returns the error kind for reading a file that is not regular.
pub fn error_kind(meta: &Metadata) -> ErrorKind {
    if meta.is_dir() { ErrorKind::IsADirectory } else { ErrorKind::Unsupported }
}

#[cfg(unix)]
fn special(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match () {
        () if kind.is_fifo() => "a fifo",
        () if kind.is_socket() => "a socket",
        () if kind.is_char_device() || kind.is_block_device() => "a device",
        () => "a special file",
    }
}

#[cfg(not(unix))]
fn special(_: FileType) -> &'static str {
    "a special file"
}

fn checked(path: &Path) -> Result<(File, Metadata)> {
    let meta = path.metadata().map_err(|e| failed(path, &e))?;
    if let Some(kind) = special_file_kind(&meta) {
        return Err(Error::system(path, format!("is {kind}, not a regular file"), error_kind(&meta)));
    }
    let file = File::open(path).map_err(|e| failed(path, &e))?;
    Ok((file, meta))
}

fn failed(path: &Path, error: &std::io::Error) -> Error {
    let reason = match error.kind() {
        ErrorKind::NotFound => "no such file".into(),
        ErrorKind::PermissionDenied => "no permission".into(),
        _ => error.to_string(),
    };
    Error::system(path, format!("cannot be read: {reason}"), error.kind())
}
