//! Motion that keeps the hand in place.

use super::profile::{HandState, MotionContext, MotionProfile};
use crate::leaf::Seconds;
use serde::{Deserialize, Serialize};

/// Keeps the hand in place, with its present squeezing force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hold {
    /// Duration, s.
    pub duration: Seconds,
}

impl MotionProfile for Hold {
    fn duration(&self) -> f64 {
        self.duration.get()
    }

    fn hand_state(&self, start: &HandState, _: f64, _: &MotionContext) -> HandState {
        *start
    }
}
