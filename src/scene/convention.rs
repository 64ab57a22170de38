//! Convention of the poses in a grasp file.

pub use super::axis::HandAxis;
use super::defaults;
pub use super::quaternion::QuaternionOrder;
use glam::DMat3;
use serde::{Deserialize, Serialize};

/// Convention of the poses in a grasp file; the default is that of DefGraspSim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Convention {
    /// Order of the four components of a quaternion; not used for matrices.
    #[serde(default = "defaults::quaternion")]
    pub quaternion: QuaternionOrder,
    /// Axis of the file's hand frame along which the fingers close.
    #[serde(default = "defaults::closing")]
    pub closing: HandAxis,
    /// Axis of the file's hand frame along which the hand approaches the object.
    #[serde(default = "defaults::approach")]
    pub approach: HandAxis,
}

impl Default for Convention {
    fn default() -> Self {
        Self { quaternion: defaults::QUATERNION, closing: defaults::CLOSING, approach: defaults::APPROACH }
    }
}

impl Convention {
    /// Returns true if the closing and approach axes are perpendicular, which every hand requires.
    pub fn is_right_angled(&self) -> bool {
        self.closing.vector().dot(self.approach.vector()) == 0.0
    }

    /// Returns the rotation from the hand frame of tactus (closing x, approach z) to that of the file.
    pub fn from_hand(&self) -> DMat3 {
        let (closing, approach) = (self.closing.vector(), self.approach.vector());
        DMat3::from_cols(closing, approach.cross(closing), approach)
    }
}
