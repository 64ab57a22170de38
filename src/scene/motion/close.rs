//! Motion that changes the squeezing force.

use super::profile::{HandState, MotionContext, MotionProfile};
use crate::leaf::{NonNegative, Seconds};
use serde::{Deserialize, Serialize};

/// Changes the squeezing force linearly in time to `force`, which is kept until the next `Close`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Close {
    /// Final force, N: the sum over the fingers. Zero releases the object.
    pub force: NonNegative,
    /// Duration, s.
    pub duration: Seconds,
}

impl MotionProfile for Close {
    fn duration(&self) -> f64 {
        self.duration.get()
    }

    fn hand_state(&self, start: &HandState, time: f64, _: &MotionContext) -> HandState {
        let s = (time / self.duration()).min(1.0);
        HandState { force: start.force + s * (self.force.get() - start.force), ..*start }
    }

    fn squeezes(&self, begin: f64, found: &mut Vec<(f64, f64)>) {
        found.push((begin + self.duration(), self.force.get()));
    }
}
