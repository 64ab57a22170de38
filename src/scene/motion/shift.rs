//! Translation of the hand.

use super::profile::{HandState, MotionContext, MotionProfile, minimum_jerk};
use crate::leaf::Seconds;
use crate::vector::Vec3;
use serde::{Deserialize, Serialize};

/// Moves the hand by a vector, starting and ending at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Move {
    /// Displacement in the world frame, m.
    pub by: Vec3,
    /// Duration, s.
    pub duration: Seconds,
}

impl MotionProfile for Move {
    fn duration(&self) -> f64 {
        self.duration.get()
    }

    fn hand_state(&self, start: &HandState, time: f64, _: &MotionContext) -> HandState {
        let by = self.by.dvec3() * minimum_jerk(time / self.duration());
        start.displaced(by)
    }
}
