//! Part of the way that lagged friction follows the pressure in the next iteration.
//!
//! Friction limits and planes follow at once, and the Newton direction anticipates this, so that slipping points cost nothing
//! extra. If that does not converge (a point touches in one state and not in the next), friction is frozen until the frozen
//! problem, a plain minimisation, is solved well enough to say where friction wants to go.

/// Iterations without progress after which friction is frozen.
const SWINGING: u32 = 5;
/// Progress is a residual below this part of the best.
const PROGRESS: f64 = 0.5;
/// Residual over the friction lag below which the frozen problem counts as solved.
const SOLVED: f64 = 0.1;
/// Largest ratio of the friction lags of two successive moves; above it friction moves by another part of the way.
const CONTRACTION: f64 = 0.5;
/// Smallest part of the way.
const SLOWEST: f64 = 1.0 / 32.0;

/// State of the friction lag in one Newton solve.
#[derive(Debug)]
pub(crate) struct Lagging {
    best: f64,
    stale: u32,
    frozen: bool,
    /// Flag: the solution is only on the way to a result; friction stays frozen, and its lag does not count.
    passing: bool,
    /// Part of the way that friction moves on once the frozen problem is solved.
    thaw: Option<f64>,
    /// Friction lag at the last move, N; then the part of the way of that move, and the part of the lag that was left.
    lagged: f64,
    pace: f64,
    left: f64,
}

impl Lagging {
    /// Creates the state for a solution that is a result, or only on the way to one (`passing`).
    pub fn new(passing: bool) -> Self {
        let (best, lagged, left) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        Self { best, stale: 0, frozen: false, passing, thaw: None, lagged, pace: 1.0, left }
    }

    /// Part of the way that friction goes in the next assembly.
    pub fn damping(&self) -> f64 {
        if self.stale < SWINGING { 1.0 } else { self.thaw.unwrap_or(0.0) }
    }

    /// Returns true once, when friction becomes frozen.
    pub fn freezes(&mut self) -> bool {
        let frozen = self.stale >= SWINGING;
        frozen && !std::mem::replace(&mut self.frozen, frozen)
    }

    /// Norm of the out-of-balance forces and the friction lag together, N.
    pub fn out_of_balance(&self, residual: f64, lag: f64) -> f64 {
        if self.passing && self.stale >= SWINGING { residual } else { residual.hypot(lag) }
    }

    /// Records an assembled state: out-of-balance forces, friction lag and the residual allowed, N.
    pub fn note(&mut self, residual: f64, lag: f64, allowed: f64) {
        if self.stale < SWINGING {
            let progress = residual.hypot(lag) < PROGRESS * self.best;
            self.stale = if progress { 0 } else { self.stale + 1 };
            self.best = if progress { residual.hypot(lag) } else { self.best };
        }
        let solved = !self.passing && lag > allowed && residual <= allowed.max(SOLVED * lag);
        self.thaw = solved.then(|| self.pace(lag));
    }

    /// Returns the part of the way that friction moves next, at the present `lag` (N). Friction overshoots where its move makes
    /// the pressure respond the other way: smaller parts then converge sooner. Elsewhere they do not, and friction moves all
    /// the way again.
    fn pace(&mut self, lag: f64) -> f64 {
        let left = lag / self.lagged;
        if left > CONTRACTION && self.lagged.is_finite() {
            let worse = self.pace < 1.0 && left > self.left;
            self.pace = if worse { 1.0 } else { (0.5 * self.pace).max(SLOWEST) };
        }
        (self.lagged, self.left) = (lag, left);
        self.pace
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Friction lag after `moves` moves, 1 N at first, where a full move leads to `answer` times the lag on the other side.
    fn lag_after(moves: u32, answer: f64) -> f64 {
        let (mut lagging, mut lag) = (Lagging::new(false), 1.0_f64);
        for _ in 0..moves {
            lag *= (1.0 - lagging.pace(lag) * (1.0 + answer)).abs();
        }
        lag
    }

    /// A state on the way to a result is done at 1e-3 N out of balance although friction swings by 1 N; a result is not.
    #[test]
    fn only_a_result_waits_for_friction_that_swings() {
        for passing in [true, false] {
            let mut lagging = Lagging::new(passing);
            (0..=SWINGING).for_each(|_| lagging.note(1e-3, 1.0, 1e-2));
            assert_eq!(lagging.damping() > 0.0, !passing, "friction moves on in a result alone");
            let left = lagging.out_of_balance(1e-3, 1.0);
            assert_eq!(left > 0.5, !passing, "{left} N counted out of balance");
        }
    }

    #[test]
    fn friction_that_overshoots_settles_within_ten_moves() {
        for answer in [0.0, 0.4, 1.0, 3.0, 8.0] {
            assert!(lag_after(10, answer) < 2e-2, "answer {answer}: {} N left", lag_after(10, answer));
        }
    }
}
