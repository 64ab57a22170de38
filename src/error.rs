//! Error type of the crate: a message that a user can act on.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Error with its place and its remedy.
///
/// `Display` prints one self-contained message; every variant names the thing and says what is allowed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Error in a scene file or a value of it; the text is already rendered with `file:line:column` and a caret.
    #[error("{0}")]
    Scene(String),
    /// Refusal of an argument; the text names arguments as the command line has them, like `--force`.
    #[error("error: {0}")]
    Argument(String),
    /// Failure to read or write a file, or content that is not what its format promises.
    #[error("{}: {message}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Message: the fault, its place in the file (line, element) if known, what is allowed, what to do.
        message: String,
        /// Kind of the operating system's error; None for content that is refused.
        kind: Option<ErrorKind>,
    },
    /// Mesh that can be read but not simulated (inverted, flat, open, empty ...); the message names fault and place.
    #[error("{0}")]
    Mesh(String),
    /// Request of a field of the scene that cannot be met; a loaded scene knows the place of the field.
    #[error("{source}")]
    Field {
        /// Path of the field, like `gripper.pads`.
        field: &'static str,
        /// Cause of the error.
        source: Box<Error>,
    },
    /// Start of a grasp that is not usable (initial penetration, too wide, misses the object ...).
    #[error("{0}")]
    Start(String),
    /// Failure of the solver; the state is the last accepted one.
    #[error("{0}")]
    Solver(String),
    /// Request to end; the message says what is kept.
    #[error("{0}")]
    Interrupted(String),
}

/// Result with the crate's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Turns the error into one about a field of the scene, if it is not about one yet.
    pub fn about(self, field: &'static str) -> Self {
        match self {
            own @ (Error::Field { .. } | Error::Scene(_) | Error::Argument(_)) => own,
            other => Error::Field { field, source: Box::new(other) },
        }
    }

    /// Returns an [`Error::File`] about the content of `path`.
    pub fn file(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Error::File { path: path.as_ref().to_path_buf(), message: message.into(), kind: None }
    }

    /// Returns an [`Error::File`] about `path`, which the operating system refuses.
    pub fn system(path: impl AsRef<Path>, message: impl Into<String>, kind: ErrorKind) -> Self {
        Error::File { path: path.as_ref().to_path_buf(), message: message.into(), kind: Some(kind) }
    }
}
