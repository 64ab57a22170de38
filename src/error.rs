//! The one error type of the crate: a message a user can act on.

use std::path::{Path, PathBuf};

/// What went wrong, where, and what to do about it.
///
/// `Display` prints one self-contained message; every variant names the thing and says what is allowed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scene file, or a value in it, is wrong; the text is already rendered with `file:line:column` and a caret.
    #[error("{0}")]
    Scene(String),
    /// A file could not be read or written, or its content is not what its format promises.
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong, where in the file (line, element) if known, what is allowed, what to do.
        message: String,
    },
    /// A mesh that is read fine but cannot be simulated (inverted, flat, open, empty ...), naming what and where.
    #[error("{0}")]
    Mesh(String),
    /// What a field of the scene asks for cannot be made; a loaded scene knows where the field stands.
    #[error("{source}")]
    Field {
        /// Path of the field, like `gripper.pads`.
        field: &'static str,
        /// Why.
        source: Box<Error>,
    },
    /// The start of a grasp is not usable (initial penetration, too wide, misses the object ...).
    #[error("{0}")]
    Start(String),
    /// The solver gave up; the state is the last accepted one.
    #[error("{0}")]
    Solver(String),
    /// Somebody asked for an end; says what is kept.
    #[error("{0}")]
    Interrupted(String),
}

/// Result with the crate's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// The same error as one about a field of the scene, if it is not about one yet.
    pub fn about(self, field: &'static str) -> Self {
        match self {
            own @ (Error::Field { .. } | Error::Scene(_)) => own,
            other => Error::Field { field, source: Box::new(other) },
        }
    }

    /// An [`Error::File`] about `path`.
    pub fn file(path: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Error::File { path: path.as_ref().to_path_buf(), message: message.into() }
    }
}
