//! Friction that follows the pressure in each iteration, or is lagged (limits and planes held fixed).
//!
//! By default, limits and planes are updated in every iteration, and the Newton direction accounts for this, so that
//! slipping points take no additional iterations. If that does not converge (a point is in contact in one state and not
//! in the next), friction is lagged until the problem with fixed limits, a plain minimisation, is solved well enough to
//! give the next limits.

/// Iterations without progress after which friction is lagged.
const STALLED_ITERATIONS: u32 = 5;
/// Residual over the smallest one so far below which an iteration counts as progress.
const PROGRESS_RATIO: f64 = 0.5;
/// Residual over the friction lag below which the problem with lagged friction counts as solved.
const LAGGED_TOLERANCE: f64 = 0.1;

/// State of the friction lag in one Newton solve.
#[derive(Debug)]
pub(crate) struct Lagging {
    best: f64,
    stalled: u32,
    frozen: bool,
    /// Flag: the solution is intermediate, not a result; friction stays lagged, and its lag error is ignored.
    intermediate: bool,
    /// Flag: the problem with lagged friction is solved, and friction is updated.
    solved: bool,
}

impl Lagging {
    /// Creates the state for a result or for an `intermediate` solution.
    pub fn new(intermediate: bool) -> Self {
        Self { best: f64::INFINITY, stalled: 0, frozen: false, intermediate, solved: false }
    }

    /// Returns true if friction is updated in the next assembly.
    pub fn updates_friction(&self) -> bool {
        self.stalled < STALLED_ITERATIONS || self.solved
    }

    /// Returns true once, when friction becomes lagged.
    pub fn becomes_lagged(&mut self) -> bool {
        let frozen = self.stalled >= STALLED_ITERATIONS;
        frozen && !std::mem::replace(&mut self.frozen, frozen)
    }

    /// Norm of the out-of-balance forces and the friction lag together, N.
    pub fn out_of_balance(&self, residual: f64, lag: f64) -> f64 {
        if self.intermediate && self.stalled >= STALLED_ITERATIONS { residual } else { residual.hypot(lag) }
    }

    /// Records an assembled state: out-of-balance forces, friction lag and admissible residual, N.
    pub fn record(&mut self, residual: f64, lag: f64, allowed: f64) {
        if self.stalled < STALLED_ITERATIONS {
            let progress = residual.hypot(lag) < PROGRESS_RATIO * self.best;
            self.stalled = if progress { 0 } else { self.stalled + 1 };
            self.best = if progress { residual.hypot(lag) } else { self.best };
        }
        self.solved = !self.intermediate && lag > allowed && residual <= allowed.max(LAGGED_TOLERANCE * lag);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An intermediate state converges at 1e-3 N out of balance although friction oscillates by 1 N; a result does not.
    #[test]
    fn only_a_result_waits_for_friction_that_swings() {
        for intermediate in [true, false] {
            let mut lagging = Lagging::new(intermediate);
            (0..=STALLED_ITERATIONS).for_each(|_| lagging.record(1e-3, 1.0, 1e-2));
            assert_eq!(lagging.updates_friction(), !intermediate, "friction moves on in a result alone");
            let left = lagging.out_of_balance(1e-3, 1.0);
            assert_eq!(left > 0.5, !intermediate, "{left} N counted out of balance");
        }
    }
}
