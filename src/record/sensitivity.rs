//! What a small change of a grasp does to its answer, as `run.json` lists it.

use super::Status;
use serde::{Deserialize, Serialize};

/// What is changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// Friction is 0.1 larger.
    Friction,
    /// The hand is turned by half a degree about the finger width.
    Turn,
    /// The hand is shifted by 0.2 mm along the approach.
    Shift,
    /// A free object is let go at half the force.
    Release,
}

/// What a change does to the last frame of a grasp.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Moved {
    /// What was changed.
    pub change: Change,
    /// How the grasp ended with it.
    pub status: Status,
    /// Distance of the displacements of both pads over their norm, L2 over the volume; None unless both grasps were reached.
    pub displacement: Option<f64>,
    /// How much farther the object moved since first contact, rotations by its bounding radius, m; None unless both were reached.
    pub object_m: Option<f64>,
}

impl Change {
    /// Name in a table.
    pub fn name(self) -> &'static str {
        match self {
            Change::Friction => "friction +0.1",
            Change::Turn => "hand turned 0.5 degrees",
            Change::Shift => "hand shifted 0.2 mm",
            Change::Release => "let go at half the force",
        }
    }
}
