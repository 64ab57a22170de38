//! Oscillation of the hand.

use super::profile::{HandState, MotionContext, MotionProfile, minimum_jerk};
use crate::leaf::{Length, Positive, Seconds};
use crate::vector::Direction;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Moves the hand by `amplitude sin(2 pi frequency t)` along a direction. The amplitude rises smoothly over the first
/// period and falls over the last (at most half of the duration each), so that the motion starts and ends at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shake {
    /// Amplitude, m.
    pub amplitude: Length,
    /// Frequency, Hz.
    pub frequency: Positive,
    /// Direction in the world frame, of any nonzero length.
    pub direction: Direction,
    /// Duration, s.
    pub duration: Seconds,
}

impl MotionProfile for Shake {
    fn duration(&self) -> f64 {
        self.duration.get()
    }

    fn hand_state(&self, start: &HandState, time: f64, _: &MotionContext) -> HandState {
        let (duration, frequency) = (self.duration(), self.frequency.get());
        let fade = (1.0 / frequency).min(0.5 * duration);
        let amplitude = self.amplitude.get() * minimum_jerk(time / fade) * minimum_jerk((duration - time) / fade);
        let by = self.direction.unit() * (amplitude * (TAU * frequency * time).sin());
        start.displaced(by)
    }
}
