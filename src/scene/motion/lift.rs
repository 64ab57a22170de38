//! Motion against gravity.

use super::play::{HandState, Play, Stage, smooth};
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

impl Play for Lift {
    fn duration(&self) -> f64 {
        self.duration.get()
    }

    fn hand(&self, start: &HandState, time: f64, stage: &Stage) -> HandState {
        let by = stage.up * (self.height.get() * smooth(time / self.duration()));
        start.displaced(by)
    }

    fn needs_gravity(&self) -> bool {
        true
    }
}
