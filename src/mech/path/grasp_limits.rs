//! Pose in which an object was grasped, and the limits of its motion from there.

use crate::potential::state::State;
use glam::{DQuat, DVec3};

/// Pose of the object when it was grasped, and its largest motion while it counts as held.
#[derive(Debug, Clone, Copy)]
pub struct GraspLimits {
    /// Position of the object when it was grasped, m, hand frame.
    pub position: DVec3,
    /// Orientation of the object when it was grasped.
    pub rotation: DQuat,
    /// Centre of the grasp, m, hand frame.
    pub center: DVec3,
    /// Largest motion of the object's point that was at the centre, m.
    pub distance: f64,
    /// Largest rotation of the object, rad.
    pub angle: f64,
}

impl GraspLimits {
    /// Returns true if the object in `state` has moved beyond these limits.
    pub fn is_exceeded(&self, state: &State) -> bool {
        let turn = state.rotation * self.rotation.inverse();
        let now = state.position + turn * (self.center - self.position);
        now.distance(self.center) > self.distance || turn.to_scaled_axis().length() > self.angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// An object whose origin is 0.3 m away rotates by 30 degrees about the grasp: it counts as held, although its
    /// origin moves by 0.16 m. One that slides by 11 mm, or rotates by 90 degrees, has left the grasp.
    #[test]
    fn an_object_that_turns_in_the_hand_stays() {
        let center = DVec3::Z * 0.1;
        let place = GraspLimits {
            position: center + DVec3::Y * 0.3,
            rotation: DQuat::IDENTITY,
            center,
            distance: 0.01,
            angle: 0.8,
        };
        let about = |angle: f64, slide: f64| {
            let rotation = DQuat::from_rotation_x(angle);
            let position = center + rotation * (place.position - center) + DVec3::Y * slide;
            State { x: Vec::new(), travel: Vec::new(), position, rotation }
        };
        assert!(!place.is_exceeded(&about(FRAC_PI_2 / 3.0, 0.0)));
        assert!(!place.is_exceeded(&about(0.0, 0.009)));
        assert!(place.is_exceeded(&about(0.0, 0.011)));
        assert!(place.is_exceeded(&about(FRAC_PI_2, 0.0)));
    }
}
