//! Reads the text of a scene file, with the reason for a failure.

use base::error::{Error, Result};
pub use base::files::include::MAX_TOTAL_SIZE;
use base::files::regular::{error_kind, special_file_kind};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Returns true for a stream that the process already has open: `-`, `/dev/stdin`, and `/dev/fd/N`, by which a shell
/// passes `<(...)`. A stream has no folder.
pub(super) fn is_stream(path: &Path) -> bool {
    let open = ["/dev/stdin", "/dev/fd", "/proc/self/fd"];
    path == Path::new("-") || (cfg!(unix) && open.iter().any(|folder| path.starts_with(folder)))
}

/// Returns the path of a scene file as shown in messages.
pub(super) fn display_path(path: &Path) -> &Path {
    if path == Path::new("-") { Path::new("<stdin>") } else { path }
}

/// Opens a scene file, or a stream.
fn open(path: &Path, may_stream: bool) -> Result<Box<dyn Read>> {
    let streams = may_stream && is_stream(path);
    if streams && (path == Path::new("-") || path == Path::new("/dev/stdin")) {
        return Ok(Box::new(std::io::stdin()));
    }
    let unopened = |e: std::io::Error| Error::system(path, format!("cannot be opened: {}", reason(&e)), e.kind());
    // Opening a FIFO may block forever, and reading a device may never end.
    let meta = path.metadata().map_err(unopened)?;
    if let Some(kind) = special_file_kind(&meta).filter(|_| !streams) {
        return Err(Error::system(path, format!("is {kind}, not a scene file"), error_kind(&meta)));
    }
    Ok(Box::new(File::open(path).map_err(unopened)?))
}

/// Reads a text of at most [`MAX_TOTAL_SIZE`] bytes from a regular file or, if it `may_stream`, from an open stream;
/// every error message names the file.
pub(super) fn read(path: &Path, may_stream: bool) -> Result<String> {
    let file = open(path, may_stream)?;
    let mut bytes = Vec::new();
    // one byte more than allowed distinguishes too large from just fitting, also for a growing file
    let read = file.take(MAX_TOTAL_SIZE + 1).read_to_end(&mut bytes);
    read.or_else(|e| fail(path, format!("cannot be read: {}", reason(&e))))?;
    if bytes.len() as u64 > MAX_TOTAL_SIZE {
        return fail(path, format!("is larger than {} MiB, the limit for a scene file", MAX_TOTAL_SIZE >> 20));
    }
    if let Some(at) = bytes.iter().position(|&b| b == 0) {
        return fail(path, format!("is not a text file (zero byte at offset {at}); a scene is RON text"));
    }
    let text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(e) => {
            let good = e.utf8_error().valid_up_to();
            let line = 1 + e.as_bytes()[..good].iter().filter(|&&b| b == b'\n').count();
            return fail(path, format!("is not UTF-8 text (line {line}, byte offset {good}); a scene is RON text"));
        }
    };
    // editors on Windows may write a byte order mark
    Ok(text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text))
}

fn failure(path: &Path, what: impl std::fmt::Display) -> Error {
    Error::Scene(format!("error: {} {what}", display_path(path).display()))
}

fn fail<T>(path: &Path, what: impl std::fmt::Display) -> Result<T> {
    Err(failure(path, what))
}

fn reason(e: &std::io::Error) -> String {
    match e.kind() {
        std::io::ErrorKind::NotFound => "no such file".to_string(),
        std::io::ErrorKind::PermissionDenied => "no permission".to_string(),
        _ => e.to_string(),
    }
}
