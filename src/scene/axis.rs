//! Signed axis of a hand frame.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Signed axis of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename = "axis")]
#[allow(missing_docs)]
pub enum HandAxis {
    X,
    Y,
    Z,
    MinusX,
    MinusY,
    MinusZ,
}

impl HandAxis {
    /// Returns the unit vector.
    pub fn vector(self) -> DVec3 {
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
            Self::MinusX => DVec3::NEG_X,
            Self::MinusY => DVec3::NEG_Y,
            Self::MinusZ => DVec3::NEG_Z,
        }
    }
}
