//! Motion that repeats others.

use super::{HandState, Motion, Play, Stage, duration, follow, squeezes};
use crate::leaf::Count;
use serde::{Deserialize, Serialize};

/// Executes a sequence of motions several times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Repeat {
    /// Number of repetitions.
    pub times: Count<1, 10000>,
    /// Motions to repeat.
    pub motions: Vec<Motion>,
}

impl Play for Repeat {
    fn duration(&self) -> f64 {
        self.times.get() as f64 * duration(&self.motions)
    }

    fn hand(&self, start: &HandState, time: f64, stage: &Stage) -> HandState {
        let (mut hand, mut rest, once) = (*start, time, duration(&self.motions));
        for _ in 1..self.times.get() {
            if rest < once {
                break;
            }
            hand = follow(&self.motions, &hand, once, stage);
            rest -= once;
        }
        follow(&self.motions, &hand, rest, stage)
    }

    fn squeezes(&self, begin: f64, found: &mut Vec<(f64, f64)>) {
        let once = squeezes(&self.motions);
        found.extend(once.into_iter().map(|(end, force)| (begin + end, force)));
    }

    fn needs_gravity(&self) -> bool {
        self.motions.iter().any(|m| m.play().needs_gravity())
    }
}
