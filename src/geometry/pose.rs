//! Grasp pose, and the transforms between hand and object frame.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Pose of the hand in the object frame: `x_object = rotation * x_hand + position`.
///
/// Hand frame: origin at the hand base, +z the approach, fingers close along x, y the finger width; contacts lie near
/// z = 0.1 m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Origin of the hand in the object frame, m.
    pub position: DVec3,
    /// Rotation from the hand frame to the object frame, length 1.
    pub rotation: DQuat,
}

impl Pose {
    /// Creates the pose from a row of a file: px py pz qw qx qy qz, not normalised. `row` has at least these seven
    /// numbers.
    pub fn from_row(row: &[f64]) -> Self {
        let rotation = DQuat::from_xyzw(row[4], row[5], row[6], row[3]);
        Self { position: DVec3::from_slice(row), rotation }
    }

    /// Returns the row for a file: px py pz qw qx qy qz.
    pub fn row(&self) -> [f64; 7] {
        let (p, q) = (self.position, self.rotation);
        [p.x, p.y, p.z, q.w, q.x, q.y, q.z]
    }

    /// Transforms a point of the object to the hand frame, m.
    pub fn inverse_transform(&self, x: DVec3) -> DVec3 {
        self.rotation.conjugate() * (x - self.position)
    }

    /// Transforms a point of the hand to the object frame, m.
    pub fn transform(&self, x: DVec3) -> DVec3 {
        self.rotation * x + self.position
    }

    /// Returns the pose of the object in the hand frame: `x_hand = rotation * x_object + position`.
    pub fn inverse(&self) -> Pose {
        let rotation = self.rotation.conjugate();
        Pose { position: -(rotation * self.position), rotation }
    }
}
