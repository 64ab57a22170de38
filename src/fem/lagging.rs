//! How far lagged friction follows the pressure in the next iteration.
//!
//! Friction limits and planes follow at once, and the Newton direction foresees it, so that slipping points cost nothing extra.
//! Where that does not converge (a point touching in one state and not in the next), friction is frozen until the frozen
//! problem, a plain minimisation, is solved well enough to say where friction wants to go.

/// Iterations without progress after which friction is frozen.
const SWINGING: u32 = 5;
/// Progress is a residual below this part of the best.
const PROGRESS: f64 = 0.5;
/// The frozen problem counts as solved at this part of what friction lags.
const SOLVED: f64 = 0.1;

/// The state of one Newton solve.
#[derive(Debug)]
pub(super) struct Lagging {
    best: f64,
    stale: u32,
    /// The frozen problem is solved, friction moves on by this part of the way.
    thaw: Option<f64>,
    /// What friction lagged when it moved on last, N.
    lagged: f64,
}

impl Default for Lagging {
    fn default() -> Self {
        Self { best: f64::INFINITY, stale: 0, thaw: None, lagged: f64::INFINITY }
    }
}

impl Lagging {
    /// Part of the way that friction goes in the next assembly.
    pub fn damping(&self) -> f64 {
        if self.stale < SWINGING { 1.0 } else { self.thaw.unwrap_or(0.0) }
    }

    /// Takes note of an assembled state: out-of-balance forces, what friction still lags, and what is allowed, N.
    pub fn note(&mut self, residual: f64, lag: f64, allowed: f64) {
        if self.stale < SWINGING {
            let progress = residual.hypot(lag) < PROGRESS * self.best;
            self.stale = if progress { 0 } else { self.stale + 1 };
            self.best = if progress { residual.hypot(lag) } else { self.best };
        }
        self.thaw = (lag > allowed && residual <= allowed.max(SOLVED * lag)).then(|| {
            let whole = lag <= 0.5 * self.lagged;
            self.lagged = lag;
            if whole { 1.0 } else { 0.5 }
        });
    }
}
