//! Interface of a motion of the hand.

use geometry::Pose;
use glam::DVec3;

/// Pose and squeezing force of the hand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandState {
    /// Pose of the hand in the world.
    pub pose: Pose,
    /// Sum of the closing forces of the fingers, N.
    pub force: f64,
}

impl HandState {
    /// Returns this state with the hand displaced by `by` (m, world frame).
    pub(super) fn displaced(&self, by: DVec3) -> Self {
        Self { pose: Pose { position: self.pose.position + by, ..self.pose }, ..*self }
    }
}

/// Properties of the scene that a motion needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionContext {
    /// Unit vector against gravity, world; zero without gravity.
    pub up: DVec3,
    /// Point midway between the pads, hand frame, m.
    pub center: DVec3,
}

/// Motion of the hand.
pub trait MotionProfile {
    /// Returns the duration, s.
    fn duration(&self) -> f64;
    /// Returns the state of the hand at `time` (0 to the duration, s) after the start of the motion from `start`.
    fn hand_state(&self, start: &HandState, time: f64, stage: &MotionContext) -> HandState;
    /// Adds to `found` the end time (s) and the force (N) of every squeeze of a motion that begins at `begin` (s).
    fn squeezes(&self, _begin: f64, _found: &mut Vec<(f64, f64)>) {}
    /// Returns true if the direction of the motion is defined by gravity.
    fn needs_gravity(&self) -> bool {
        false
    }
}

/// Rises from 0 to 1 with zero velocity and acceleration at both ends (minimum jerk: Flash & Hogan 1985, equation 2).
pub(super) fn minimum_jerk(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
}
