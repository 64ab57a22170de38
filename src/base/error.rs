//! Error type of the crate; every message is one that a user can act on.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Error with its location and its remedy.
///
/// `Display` prints one self-contained message; every variant names the faulty item and states what is allowed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Error in a scene file or in one of its values; the text is already rendered with `file:line:column` and a caret.
    #[error("{0}")]
    Scene(String),
    /// Rejected argument; the text names arguments as on the command line, like `--force`.
    #[error("error: {0}")]
    Argument(String),
    /// Failure to read or write a file, or content that violates its format.
    #[error("{}: {message}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Message: the fault, its place in the file (line, element) if known, what is allowed, what to do.
        message: String,
        /// Kind of the operating system's error; None for rejected content.
        kind: Option<ErrorKind>,
    },
    /// Mesh that can be read but not simulated (inverted, flat, open, empty ...); the message names the fault and its
    /// location.
    #[error("{0}")]
    Mesh(String),
    /// Error that concerns a field of the scene; a loaded scene adds the location of the field.
    #[error("{source}")]
    Field {
        /// Path of the field, like `gripper.pads`.
        field: &'static str,
        /// Cause of the error.
        source: Box<Error>,
    },
    /// Invalid start of a grasp (initial penetration, too wide, misses the object ...).
    #[error("{0}")]
    Start(String),
    /// Failure of the solver; the state is the last accepted one.
    #[error("{0}")]
    Solver(String),
    /// Interruption on request; the message states what is kept.
    #[error("{0}")]
    Interrupted(String),
}

/// Result with the crate's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Attributes the error to the field `field` of the scene, unless it already concerns a field, a scene or an
    /// argument.
    pub fn with_field(self, field: &'static str) -> Self {
        match self {
            own @ (Error::Field { .. } | Error::Scene(_) | Error::Argument(_)) => own,
            other => Error::Field { field, source: Box::new(other) },
        }
    }

    /// Returns an [`Error::File`] about the content of `path`.
    pub fn file(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Error::File { path: path.as_ref().to_path_buf(), message: message.into(), kind: None }
    }

    /// Returns an [`Error::File`] about `path`, for an error of the operating system.
    pub fn system(path: impl AsRef<Path>, message: impl Into<String>, kind: ErrorKind) -> Self {
        Error::File { path: path.as_ref().to_path_buf(), message: message.into(), kind: Some(kind) }
    }
}
