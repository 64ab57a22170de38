//! Pose of a frame in another one, and the transforms between the two.

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Pose of a frame A in a frame B: `x_B = rotation * x_A + position`. The pose of a grasp is that of the hand in the
/// object frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Origin of A in B, m.
    pub position: DVec3,
    /// Rotation from A to B, length 1.
    pub rotation: DQuat,
}

impl Pose {
    /// Pose of a frame in itself.
    pub const IDENTITY: Self = Self { position: DVec3::ZERO, rotation: DQuat::IDENTITY };

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

    /// Transforms a point from A to B, m.
    pub fn transform(&self, x: DVec3) -> DVec3 {
        self.rotation * x + self.position
    }

    /// Transforms a point from B to A, m.
    pub fn inverse_transform(&self, x: DVec3) -> DVec3 {
        self.rotation.conjugate() * (x - self.position)
    }

    /// Returns the pose of B in A.
    pub fn inverse(&self) -> Pose {
        let rotation = self.rotation.conjugate();
        Pose { position: -(rotation * self.position), rotation }
    }
}
