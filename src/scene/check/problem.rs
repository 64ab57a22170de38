//! Error of a check across fields.

/// Error of a field that is inconsistent with the rest of the scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Problem {
    /// Path of the field, like `object.shape.inner`.
    pub path: String,
    /// Error message; further lines are the help.
    pub message: String,
}

/// Returns the error of the field at `path`.
pub(super) fn problem_at<T>(path: impl Into<String>, message: impl Into<String>) -> Result<T, Problem> {
    Err(Problem { path: path.into(), message: message.into() })
}
