//! Effect of a small change of a grasp on its result, as `run.json` lists it.

use super::status::Status;
use serde::{Deserialize, Serialize};

/// Change of a grasp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Change {
    /// Friction coefficient larger by 0.1.
    Friction,
    /// Hand rotated by half a degree about the finger width axis.
    Turn,
    /// Hand shifted by 0.2 mm along the approach.
    Shift,
    /// Free object released at half the force.
    Release,
}

/// Effect of a change on the last frame of a grasp.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ChangeEffect {
    /// Change that was made.
    pub change: Change,
    /// Outcome of the grasp with the change.
    pub status: Status,
    /// L2 norm over the volume of the difference of the pad displacements, relative to their norm; None unless both
    /// grasps reach their load.
    pub displacement: Option<f64>,
    /// Difference of the object's motion since first contact: translation plus rotation times the bounding radius, m;
    /// None unless both grasps reach their load.
    pub object_m: Option<f64>,
}

impl Change {
    /// Returns the name of the change in a table.
    pub fn name(self) -> &'static str {
        match self {
            Change::Friction => "friction +0.1",
            Change::Turn => "hand rotated by 0.5 degrees",
            Change::Shift => "hand shifted by 0.2 mm",
            Change::Release => "released at half the force",
        }
    }
}
