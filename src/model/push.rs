//! Push on a squeezed object.

use geometry::Wrench;
use glam::{DQuat, DVec3};
use scene::loading::ObjectPush;

/// Dead load of a push, and the fraction of it in each frame.
#[derive(Debug, Clone, PartialEq)]
pub struct PushLoad {
    /// Force on the centre of mass, N, hand frame.
    pub force: DVec3,
    /// Torque, N m, hand frame, at the object's rotation at first contact.
    pub torque: DVec3,
    /// Fraction of the push in each frame, 0 to 1.
    pub fractions: Vec<f64>,
}

/// Fraction of a push in its first increment.
pub const FIRST_FRACTION: f64 = 0.05;

impl PushLoad {
    /// Creates the push after a squeeze of `frames` frames.
    pub fn new(push: &ObjectPush, frames: usize) -> Self {
        let parts = std::iter::repeat_n(0.0, frames).chain(push.push_fractions()).collect();
        Self { force: push.force.dvec3(), torque: push.torque.dvec3(), fractions: parts }
    }

    /// Returns the fraction `part` of the push.
    pub fn fraction_of(&self, part: f64) -> Wrench {
        Wrench { force: self.force, torque: self.torque } * part
    }

    /// Returns the lever arms of the torque (m, hand frame) with the forces at their ends (N):
    /// `torque = sum of arm x force`. There are two couples, so that all directions perpendicular to the torque are
    /// equivalent.
    pub fn couple(&self, length: f64) -> Vec<(DVec3, DVec3)> {
        let Some(axis) = self.torque.try_normalize() else { return Vec::new() };
        let across = axis.any_orthonormal_vector() * length;
        let arms = [across, axis.cross(across)];
        let force = |arm: DVec3| self.torque.cross(arm) / (4.0 * length * length);
        arms.into_iter().flat_map(|arm| [(arm, force(arm)), (-arm, -force(arm))]).collect()
    }

    /// Returns the torque of the full push on an object rotated by `turn` since first contact, N m, hand frame.
    pub fn torque_after(&self, turn: DQuat) -> DVec3 {
        self.couple(1.0).into_iter().map(|(arm, force)| (turn * arm).cross(force)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_couple_has_the_torque_and_no_force() {
        let push = PushLoad { force: DVec3::X, torque: DVec3::new(0.3, -0.2, 0.5), fractions: vec![1.0] };
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
