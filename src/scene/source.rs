//! Reading of the text of a scene file, with the reason if it fails.

use crate::error::{Error, Result};
pub use crate::files::include::SIZE_LIMIT;
use crate::files::regular::{other_kind, refusal};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Reads a text of at most [`SIZE_LIMIT`] bytes; each failure is one message that names the file.
pub(super) fn read(path: &Path) -> Result<String> {
    let unopened = |e: std::io::Error| Error::system(path, format!("cannot be opened: {}", reason(&e)), e.kind());
    // A fifo may block for ever, a device may never end.
    let meta = path.metadata().map_err(unopened)?;
    if let Some(kind) = other_kind(&meta) {
        return Err(Error::system(path, format!("is {kind}, not a scene file"), refusal(&meta)));
    }
    let file = File::open(path).map_err(unopened)?;
    let mut bytes = Vec::new();
    // one byte more than allowed tells too large from just fitting, also for files that grow
    let read = file.take(SIZE_LIMIT + 1).read_to_end(&mut bytes);
    read.or_else(|e| fail(path, format!("cannot be read: {}", reason(&e))))?;
    if bytes.len() as u64 > SIZE_LIMIT {
        return fail(path, format!("is larger than {} MiB, the limit for a scene file", SIZE_LIMIT >> 20));
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
    // editors on Windows may put a byte order mark first
    Ok(text.strip_prefix('\u{feff}').map(str::to_string).unwrap_or(text))
}

fn fail<T>(path: &Path, what: impl std::fmt::Display) -> Result<T> {
    Err(Error::Scene(format!("error: {} {what}", path.display())))
}

fn reason(e: &std::io::Error) -> String {
    match e.kind() {
        std::io::ErrorKind::NotFound => "no such file".to_string(),
        std::io::ErrorKind::PermissionDenied => "no permission".to_string(),
        _ => e.to_string(),
    }
}
