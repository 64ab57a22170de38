//! Placement of the pads in the hand frame.
//!
//! Hand frame (that of DefGraspSim): origin at the hand base, +Z the approach, fingers close along X, finger width
//! along Y. The left finger is at -X and closes towards +X; the right finger is its image under a rotation by 180
//! degrees about Z.

use geometry::Pose;
use glam::{DMat3, DQuat, DVec3};

/// Number of fingers of the full gripper.
pub const SIDES: usize = 2;

/// Rigid placement of one pad at zero travel, and the closing direction of its finger.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FingerPlacement {
    /// Pad axes in hand axes: pad x (long side) along the approach, pad z (out of the gel) along the closing direction.
    pub rotation: DMat3,
    /// Centre of the sensing face, m.
    pub origin: DVec3,
    /// Closing direction, unit.
    pub closing: DVec3,
}

impl FingerPlacement {
    /// Creates the placement of finger `side` (0 left, 1 right) for the distance `opening` (m) between the sensing
    /// faces, whose centres are at `height` (m) along the approach.
    pub fn new(side: usize, opening: f64, height: f64) -> Self {
        let closing = if side == 0 { DVec3::X } else { DVec3::NEG_X };
        let across = closing.cross(DVec3::Z);
        Self {
            rotation: DMat3::from_cols(DVec3::Z, across, closing),
            origin: DVec3::Z * height - closing * (0.5 * opening),
            closing,
        }
    }

    /// Returns the placement as a pose: `x_hand = rotation * x_pad + position`.
    pub fn pose(&self) -> Pose {
        Pose { position: self.origin, rotation: DQuat::from_mat3(&self.rotation) }
    }

    /// Returns the position in the hand frame of a point given in the pad frame, m.
    pub fn place(&self, x: DVec3) -> DVec3 {
        self.rotation * x + self.origin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pads_face_each_other_as_proper_rotations() {
        for side in 0..SIDES {
            let p = FingerPlacement::new(side, 0.08, 0.1);
            assert_eq!(p.rotation.determinant(), 1.0, "side {side} is not mirrored");
            assert_eq!(p.rotation.z_axis, p.closing, "the gel faces the closing direction");
            assert_eq!(p.place(DVec3::ZERO).x.abs(), 0.04, "half the opening from the middle, m");
        }
    }
}
