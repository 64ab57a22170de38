//! Outcome of a grasp.

use serde::{Deserialize, Serialize};

/// Outcome of a grasp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Final load reached without inverted elements.
    Reached,
    /// Object dropped: it slid or rolled out of the grasp, or was not held when its support was removed. Frames up to
    /// there are valid.
    Dropped,
    /// Solver failure or invalid result; frames up to there are valid.
    Fault,
    /// Grasp that cannot start (too wide, misses the object, or begins in contact).
    Infeasible,
}

impl Status {
    /// Returns the name of the status in reports and files.
    pub fn as_str(self) -> &'static str {
        match self {
            Status::Reached => "reached",
            Status::Dropped => "dropped",
            Status::Fault => "fault",
            Status::Infeasible => "infeasible",
        }
    }
}
