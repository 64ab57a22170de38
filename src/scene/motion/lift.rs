//! Motion against gravity.

use super::profile::{HandState, MotionContext, MotionProfile, minimum_jerk};
use crate::leaf::{Finite, Seconds};
use serde::{Deserialize, Serialize};

/// Moves the hand against gravity, starting and ending at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lift {
    /// Height, m; a negative one lowers the hand.
    pub height: Finite,
    /// Duration, s.
    pub duration: Seconds,
}

impl MotionProfile for Lift {
    fn duration(&self) -> f64 {
        self.duration.get()
    }

    fn hand_state(&self, start: &HandState, time: f64, stage: &MotionContext) -> HandState {
        let by = stage.up * (self.height.get() * minimum_jerk(time / self.duration()));
        start.displaced(by)
    }

    fn needs_gravity(&self) -> bool {
        true
    }
}
