//! Push on a squeezed object.

use crate::scene::loading::ObjectPush;
use glam::{DQuat, DVec3};

/// Dead forces of a push, and the part of them that acts in each frame.
#[derive(Debug, Clone, PartialEq)]
pub struct PushLoad {
    /// Force on the centre of mass, N, hand frame.
    pub force: DVec3,
    /// Torque, N m, hand frame, on an object that is turned as at first contact.
    pub torque: DVec3,
    /// Part of the push that acts in each frame, 0 to 1.
    pub parts: Vec<f64>,
}

/// Part of a push with which its path begins.
pub const FIRST_PART: f64 = 0.05;

impl PushLoad {
    /// Creates the push of a scene whose object is squeezed in `frames` frames before.
    pub fn new(push: &ObjectPush, frames: usize) -> Self {
        let parts = std::iter::repeat_n(0.0, frames).chain(push.parts()).collect();
        Self { force: push.force.dvec3(), torque: push.torque.dvec3(), parts }
    }

    /// Returns force and torque of the part `part` of the push.
    pub fn at(&self, part: f64) -> [DVec3; 2] {
        [self.force * part, self.torque * part]
    }

    /// Returns the arms of the torque, m, hand axes, with the forces on their ends, N: `torque = sum of arm x force`. There are two pairs
    /// of opposite forces, so that no direction across the torque differs from the others.
    pub fn couple(&self, length: f64) -> Vec<(DVec3, DVec3)> {
        let Some(axis) = self.torque.try_normalize() else { return Vec::new() };
        let across = axis.any_orthonormal_vector() * length;
        let arms = [across, axis.cross(across)];
        let force = |arm: DVec3| self.torque.cross(arm) / (4.0 * length * length);
        arms.into_iter().flat_map(|arm| [(arm, force(arm)), (-arm, -force(arm))]).collect()
    }

    /// Returns the torque of the whole push on an object that has turned by `turn` since first contact, N m, hand frame.
    pub fn torque_after(&self, turn: DQuat) -> DVec3 {
        self.couple(1.0).into_iter().map(|(arm, force)| (turn * arm).cross(force)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_couple_has_the_torque_and_no_force() {
        let push = PushLoad { force: DVec3::X, torque: DVec3::new(0.3, -0.2, 0.5), parts: vec![1.0] };
        let couple = push.couple(0.02);
        assert!(couple.iter().map(|(_, force)| *force).sum::<DVec3>().length() < 1e-15);
        let torque: DVec3 = couple.iter().map(|(arm, force)| arm.cross(*force)).sum();
        assert!((torque - push.torque).length() < 1e-15, "{torque}");
        let turned = push.torque_after(DQuat::from_axis_angle(push.torque.normalize(), 0.1));
        assert!(
            (turned - push.torque * 0.1_f64.cos()).length() < 1e-12,
            "dead forces turn less when the object follows"
        );
    }
}
