//! Format of the output of a command, and its exit codes.

use base::error::Error;
use clap::ValueEnum;

/// Exit code for success: everything requested was done and every expectation holds.
pub const EXIT_OK: u8 = 0;
/// Exit code for a scene that ran, but of which an expectation does not hold or a grasp failed.
pub const EXIT_EXPECTATION_FAILED: u8 = 1;
/// Exit code for invalid arguments or files, other errors and interruptions.
pub const EXIT_ERROR: u8 = 2;

/// Format of the output on stdout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Format {
    /// Human-readable text.
    #[default]
    Text,
    /// JSON object.
    Json,
}

/// Returns `error`; if it is an interruption, its message states what is kept.
pub(super) fn with_kept_note(error: Error, kept: impl FnOnce() -> String) -> Error {
    match error {
        Error::Interrupted(_) => Error::Interrupted(format!("interrupted; {}", kept())),
        other => other,
    }
}
