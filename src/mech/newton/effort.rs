//! Bound on the work of a grasp, so that every grasp terminates.
//!
//! A grasp takes at most `max_iterations * (START_INCREMENTS + INCREMENTS_PER_STEP * steps)` Newton iterations. The
//! scene sets `max_iterations`, 40 by default. The number of steps is that of the recorded frames or, in a dynamic
//! scene, of the time steps. A step of an agent takes at most `max_iterations * INCREMENTS_PER_STEP`, because all
//! environments of a batch wait for it. The bound is the same on every machine. A limit on wall time, which depends on
//! the machine, can be set as well.

use super::Failure;
use base::interrupt;
use std::time::{Duration, Instant};

/// Number of increments, of `max_iterations` each, that a grasp may take to make contact and reach equilibrium, and for
/// each step after that.
const START_INCREMENTS: u64 = 50;
const INCREMENTS_PER_STEP: u64 = 10;

/// Maximum number of Newton iterations of a grasp with `steps` load levels or time steps, for `max_iterations` per
/// increment.
pub fn iteration_limit(max_iterations: u32, steps: usize) -> u64 {
    u64::from(max_iterations)
        .saturating_mul(START_INCREMENTS.saturating_add(INCREMENTS_PER_STEP.saturating_mul(steps as u64)))
}

/// Maximum number of Newton iterations of a step of an agent.
pub fn agent_step_iteration_limit(max_iterations: u32) -> u64 {
    u64::from(max_iterations).saturating_mul(INCREMENTS_PER_STEP)
}

/// Limit on the work of a solver.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Number of Newton iterations of the grasp at which counting begins.
    pub from: u64,
    /// Maximum number of Newton iterations counted.
    pub iterations: u64,
    /// Deadline of the solver, and the wall time allowed, s.
    deadline: Option<(Instant, f64)>,
}

impl Default for Effort {
    /// Sets no limit.
    fn default() -> Self {
        Self { from: 0, iterations: u64::MAX, deadline: None }
    }
}

impl Effort {
    /// Limits the wall time to `seconds` from now, if given.
    pub fn within(seconds: Option<f64>) -> Self {
        let until = |s: f64| Some((Instant::now().checked_add(Duration::try_from_secs_f64(s).ok()?)?, s));
        Self { deadline: seconds.and_then(until), ..Self::default() }
    }

    /// Returns the reason why a solver that has taken this many iterations must stop; None if it may continue.
    pub fn exceeded(&self, iterations: u64) -> Option<Failure> {
        if interrupt::requested() {
            return Some(Failure::Interrupted);
        }
        if iterations.saturating_sub(self.from) >= self.iterations {
            return Some(Failure::Effort(self.iterations));
        }
        self.deadline.filter(|(until, _)| Instant::now() >= *until).map(|(_, seconds)| Failure::Time(seconds))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step may take its ten iterations regardless of those of the grasp before it.
    #[test]
    fn iterations_count_from_the_start_of_the_step() {
        let effort = Effort { from: 500, iterations: 10, ..Effort::default() };
        assert_eq!(effort.exceeded(509), None);
        assert_eq!(effort.exceeded(510), Some(Failure::Effort(10)));
    }
}
