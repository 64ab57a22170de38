//! Conversion of tactus errors to Python exceptions.

use pyo3::PyErr;
use pyo3::exceptions::{PyOSError, PyValueError};
use std::fmt::Display;
use std::io::ErrorKind;
use tactus::base::error::Error;

/// Python exception of a tactus error.
pub struct Refusal(pub PyErr);

impl From<Error> for Refusal {
    /// Converts a file error of the operating system to the corresponding `OSError`, e.g. `FileNotFoundError`, and any
    /// other error to a `ValueError` with the same message; command-line options in it are replaced by Python argument
    /// names.
    fn from(error: Error) -> Self {
        let number = match &error {
            Error::File { kind: Some(kind), .. } => number(*kind),
            _ => None,
        };
        Self(match (error, number) {
            // Python selects the subclass by the error number.
            (Error::File { path, message, .. }, Some(number)) => PyOSError::new_err((number, message, path)),
            (Error::Argument(text), _) => refused(format!("error: {}", named(&text))),
            (error, _) => refused(error),
        })
    }
}

impl From<String> for Refusal {
    fn from(message: String) -> Self {
        Self(refused(message))
    }
}

impl From<Refusal> for PyErr {
    fn from(refusal: Refusal) -> Self {
        refusal.0
    }
}

/// Returns a `ValueError` with this message.
pub fn refused(message: impl Display) -> PyErr {
    PyValueError::new_err(message.to_string())
}

/// Returns the exception for an error of tactus.
pub fn raised(error: Error) -> PyErr {
    Refusal::from(error).into()
}

/// Returns the POSIX error number, as in the module `errno`.
fn number(kind: ErrorKind) -> Option<i32> {
    match kind {
        ErrorKind::NotFound => Some(2),
        ErrorKind::PermissionDenied => Some(13),
        ErrorKind::AlreadyExists => Some(17),
        ErrorKind::NotADirectory => Some(20),
        ErrorKind::IsADirectory => Some(21),
        ErrorKind::StorageFull => Some(28),
        ErrorKind::ReadOnlyFilesystem => Some(30),
        _ => None,
    }
}

/// Replaces command-line options by argument names of Python: `--max-time` becomes `max_time`.
fn named(text: &str) -> String {
    let mut parts = text.split("--");
    let mut said = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let name = part.find(|c: char| !(c.is_ascii_lowercase() || c == '-')).unwrap_or(part.len());
        let whole = said.ends_with([' ', '`', '(', '\'']) || said.is_empty();
        if whole && name > 0 {
            said += &part[..name].replace('-', "_");
            said += &part[name..];
        } else {
            said += "--";
            said += part;
        }
    }
    said
}
