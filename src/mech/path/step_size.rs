//! Size of the next increment.

use serde::{Deserialize, Serialize};

/// Size of an increment after a failed one, over the size of that one.
const FAILED_STEP_FACTOR: f64 = 0.5;
/// Largest growth after an easy increment.
const EASY_STEP_GROWTH: f64 = 2.0;
/// Number of iterations from which an increment counts as hard.
const HARD_INCREMENT_ITERATIONS: u32 = 15;
/// Safety factor of the size that the error admits.
const STEP_SAFETY_FACTOR: f64 = 0.8;
/// Error over the error allowed above which an increment is rejected.
pub const REJECTED_PATH_ERROR: f64 = 4.0;

/// The size of the next increment, in the unit of the load.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepSize(pub f64);

impl StepSize {
    /// Size without any known bound.
    pub const UNKNOWN: Self = Self(f64::INFINITY);

    /// Returns the next increment of the remaining load `rest`, which is divided into equal parts. A whole number of
    /// parts stays whole despite rounding.
    pub fn next(&self, rest: f64) -> f64 {
        rest / (rest.abs() / self.0 * (1.0 - 1e-9)).ceil().max(1.0)
    }

    /// Updates the size after an increment `size` that was accepted after `iterations`, with `error` over the error
    /// allowed. The error grows with the square of the size; it does not reduce the size below `shortest`.
    pub fn accept(&mut self, size: f64, iterations: u32, error: f64, shortest: f64) {
        let eased = size.abs() * if iterations < HARD_INCREMENT_ITERATIONS { EASY_STEP_GROWTH } else { 1.0 };
        let next = (size.abs() * STEP_SAFETY_FACTOR / error.sqrt()).max(shortest).min(eased);
        // A short last part does not bound longer ones.
        self.0 = if error < STEP_SAFETY_FACTOR * STEP_SAFETY_FACTOR { self.0.max(next) } else { next };
    }

    /// Updates the size after an increment `size` that was rejected, with `error` over the error allowed if that was
    /// the reason.
    pub fn reject(&mut self, size: f64, error: Option<f64>) {
        self.0 = size.abs()
            * error.map_or(FAILED_STEP_FACTOR, |error| (STEP_SAFETY_FACTOR / error.sqrt()).min(FAILED_STEP_FACTOR));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path whose error is that of a parabola reaches 1 in as many increments as the error allows, to a fifth.
    #[test]
    fn increments_are_as_many_as_the_error_allows() {
        for allowed in [1e-2, 1e-4_f64] {
            let (mut step, mut at, mut count) = (StepSize(1e-3), 0.0, 0);
            while at < 1.0 {
                let size = step.next(1.0 - at);
                let error = size * size / allowed;
                if error > REJECTED_PATH_ERROR {
                    step.reject(size, Some(error));
                    continue;
                }
                step.accept(size, 3, error, 0.0);
                (at, count) = (at + size, count + 1);
            }
            let ideal = 1.0 / (STEP_SAFETY_FACTOR * allowed.sqrt());
            assert!((f64::from(count) - ideal).abs() < 0.2 * ideal + 8.0, "{count} increments, not {ideal:.0}");
        }
    }

    #[test]
    fn the_last_parts_are_alike() {
        assert_eq!(StepSize(0.4).next(1.0), 1.0 / 3.0);
        assert_eq!(StepSize(0.4).next(-1.0), -1.0 / 3.0);
        assert_eq!(StepSize::UNKNOWN.next(1.0), 1.0);
    }
}
