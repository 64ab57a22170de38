//! Size of the next increment.

use serde::{Deserialize, Serialize};

/// Size of an increment after one that failed, over the size of that one.
const HALF: f64 = 0.5;
/// Largest growth after an increment that was easy.
const GROWTH: f64 = 2.0;
/// Number of iterations from which on an increment was hard.
const HARD: u32 = 15;
/// Part of the error allowed that the next increment aims at.
const SAFETY: f64 = 0.8;
/// Error over the error allowed from which on an increment is not accepted.
pub const REFUSED: f64 = 4.0;

/// The size of the next increment, in the unit of the load.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct StepSize(pub f64);

impl StepSize {
    /// The size before anything is known that bounds it.
    pub const UNKNOWN: Self = Self(f64::INFINITY);

    /// Returns the next part of the way `rest`: all parts that are left are alike. A whole number of parts stays one whatever
    /// the rounding.
    pub fn next(&self, rest: f64) -> f64 {
        rest / (rest.abs() / self.0 * (1.0 - 1e-9)).ceil().max(1.0)
    }

    /// Updates the size after an increment `size` that was accepted after so many `iterations`, with `error` over the error
    /// allowed. The error grows with the square of the size; it asks for no increment below `shortest`.
    pub fn accept(&mut self, size: f64, iterations: u32, error: f64, shortest: f64) {
        let eased = size.abs() * if iterations < HARD { GROWTH } else { 1.0 };
        let next = (size.abs() * SAFETY / error.sqrt()).max(shortest).min(eased);
        // A last small part says nothing against larger ones.
        self.0 = if error < SAFETY * SAFETY { self.0.max(next) } else { next };
    }

    /// Updates the size after an increment `size` that was refused, with `error` over the error allowed if that is why.
    pub fn refuse(&mut self, size: f64, error: Option<f64>) {
        self.0 = size.abs() * error.map_or(HALF, |error| (SAFETY / error.sqrt()).min(HALF));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Increments of a path whose error is that of a parabola reach 1 in as many parts as the error allows, to a fifth.
    #[test]
    fn increments_are_as_many_as_the_error_allows() {
        for allowed in [1e-2, 1e-4_f64] {
            let (mut step, mut at, mut count) = (StepSize(1e-3), 0.0, 0);
            while at < 1.0 {
                let size = step.next(1.0 - at);
                let error = size * size / allowed;
                if error > REFUSED {
                    step.refuse(size, Some(error));
                    continue;
                }
                step.accept(size, 3, error, 0.0);
                (at, count) = (at + size, count + 1);
            }
            let ideal = 1.0 / (SAFETY * allowed.sqrt());
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
