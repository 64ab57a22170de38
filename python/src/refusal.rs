//! Refusals of tactus as exceptions of Python.

use pyo3::PyErr;
use pyo3::exceptions::{PyOSError, PyValueError};
use std::fmt::Display;
use std::io::ErrorKind;
use tactus::error::Error;

/// Exception for what is refused.
pub struct Refusal(pub PyErr);

impl From<Error> for Refusal {
    /// Turns a file that the operating system refuses into the `OSError` of its kind, like `FileNotFoundError`, and all else into a
    /// `ValueError` with the message as it is; of an argument with its name in Python.
    fn from(error: Error) -> Self {
        let number = match &error {
            Error::File { kind: Some(kind), .. } => number(*kind),
            _ => None,
        };
        Self(match (error, number) {
            // Python chooses the subclass by the number.
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

/// Returns POSIX's number of an error, as the module `errno` has it.
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

/// Returns the text with options of the command line as arguments of Python: `--max-time` is `max_time`.
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
