//! Wrench: a force and a torque.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign, Mul};

/// Force, and torque about a point that the user of the type states.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// Force, N.
    pub force: DVec3,
    /// Torque, N m.
    pub torque: DVec3,
}

impl Wrench {
    /// Wrench without force and torque.
    pub const ZERO: Self = Self { force: DVec3::ZERO, torque: DVec3::ZERO };

    /// Returns the wrench in other axes: `rotate` is applied to force and torque.
    pub fn rotated(self, rotate: impl Fn(DVec3) -> DVec3) -> Self {
        Self { force: rotate(self.force), torque: rotate(self.torque) }
    }

    /// Returns force and torque as six numbers.
    pub fn row(self) -> [f64; 6] {
        let (f, t) = (self.force, self.torque);
        [f.x, f.y, f.z, t.x, t.y, t.z]
    }
}

impl Add for Wrench {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { force: self.force + other.force, torque: self.torque + other.torque }
    }
}

impl AddAssign for Wrench {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Mul<f64> for Wrench {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { force: self.force * factor, torque: self.torque * factor }
    }
}
