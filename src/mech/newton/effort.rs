//! A bound on the work of a grasp: every grasp ends.
//!
//! A grasp takes at most `max_iterations * (START + PER_STEP * steps)` Newton iterations: `max_iterations` of the scene, 40 by default,
//! and as many steps as the scene records frames, or, of a dynamic scene, as time is divided into; an agent's world counts the steps taken.
//! The same scene meets the same bound on every machine. A limit on wall time, which does not, is there for the impatient.

use super::Failure;
use crate::interrupt;
use std::time::{Duration, Instant};

/// Increments of `max_iterations` that a grasp may take to make contact and to settle, and for each step after that.
const START: u64 = 50;
const PER_STEP: u64 = 10;

/// Most Newton iterations of a grasp with `steps` load levels or time steps, each of `max_iterations` per increment.
pub fn most_iterations(max_iterations: u32, steps: usize) -> u64 {
    u64::from(max_iterations).saturating_mul(START.saturating_add(PER_STEP.saturating_mul(steps as u64)))
}

/// How much a solver may do.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Newton iterations since the start of the grasp.
    pub iterations: u64,
    /// When it must have ended, and the wall time it had, s.
    deadline: Option<(Instant, f64)>,
}

impl Default for Effort {
    /// As much as it takes.
    fn default() -> Self {
        Self { iterations: u64::MAX, deadline: None }
    }
}

impl Effort {
    /// Gives it `seconds` from now on, if any.
    pub fn within(seconds: Option<f64>) -> Self {
        let until = |s: f64| Some((Instant::now().checked_add(Duration::try_from_secs_f64(s).ok()?)?, s));
        Self { deadline: seconds.and_then(until), ..Self::default() }
    }

    /// Why a solver that has taken this many iterations goes no further, if it does not.
    pub fn exceeded(&self, iterations: u64) -> Option<Failure> {
        if interrupt::requested() {
            return Some(Failure::Interrupted);
        }
        if iterations >= self.iterations {
            return Some(Failure::Effort(self.iterations));
        }
        self.deadline.filter(|(until, _)| Instant::now() >= *until).map(|(_, seconds)| Failure::Time(seconds))
    }
}
