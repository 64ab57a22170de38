//! Newton's method with line search on the incremental potential.

use super::lagging::Lagging;
use super::{Converged, Failure, Newton, NewtonTolerance};
use crate::mech::potential::state::{MAX_RIGID, NewtonStep, State};
use crate::mech::potential::term::Assembly;
use crate::scales::SHARP_MOTION;
use std::time::Instant;

/// Longest stride of the rigid unknowns in one iteration, as a part of the largest motion.
const STRIDE: f64 = 0.2;
/// Least part by which a step of friction that follows the pressure lowers the residual.
const BALANCED: f64 = 0.1;
/// Part of a step from which on it counts as whole.
const WHOLE: f64 = 0.9;
/// Part of a step below which only rounding moves.
const STUCK: f64 = 1e-9;

impl Newton {
    /// Minimises the potential from `start`, in an increment that departs from the accepted state `from`.
    ///
    /// # Errors
    /// [`Failure`] says why; the terms' history is untouched, so a smaller increment can be tried.
    pub fn solve(
        &mut self,
        from: &State,
        start: State,
        tolerance: &NewtonTolerance,
    ) -> Result<(State, Converged), Failure> {
        self.depart(from);
        let mut now = start;
        let mut last_motion = f64::INFINITY;
        let mut iterations = 0;
        let mut lagging = Lagging::new(tolerance.passing);
        let (mut how, mut assembled) = (after_step(last_motion, false, tolerance), false);
        loop {
            self.profile.frozen += u64::from(lagging.freezes());
            let clock = Instant::now();
            if !assembled {
                self.assemble(&now, how);
            }
            self.profile.assembly += clock.elapsed().as_secs_f64();
            let (residual, lag) = self.residual();
            if !residual.is_finite() {
                return Err(Failure::Singular);
            }
            let allowed = tolerance.force + tolerance.relative * self.activity();
            lagging.note(residual, lag, allowed);
            let residual = lagging.out_of_balance(residual, lag);
            let balanced = residual <= allowed && (last_motion <= tolerance.length || residual <= 0.01 * allowed);
            if balanced && self.satisfied(&now) {
                return Ok((now, Converged { iterations, residual }));
            }
            if iterations >= tolerance.iterations {
                return Err(Failure::Iterations(residual));
            }
            if balanced {
                last_motion = f64::INFINITY;
                iterations += 1;
                how = Assembly { follow: lagging.follows(), ..after_step(last_motion, how.secant, tolerance) };
                assembled = false;
                continue;
            }
            if let Some(failure) = self.effort.exceeded(self.profile.iterations) {
                return Err(failure);
            }
            if !self.factorize(&now, how) {
                return Err(Failure::Singular);
            }
            let clock = Instant::now();
            let cap = STRIDE * tolerance.motion;
            let (plain, gradient) = self.direction(cap);
            let step = if how.follow { self.follow(&now, &plain, &gradient, cap) } else { plain.clone() };
            self.profile.solve += clock.elapsed().as_secs_f64();
            // Friction that follows the pressure has no potential: its step is good if the forces come into balance by it.
            let balanced = if how.follow { self.balance(&now, &step, residual, tolerance) } else { None };
            assembled = balanced.is_some() && lagging.follows();
            let clock = Instant::now();
            let searched = balanced.or_else(|| {
                // What has no potential may lead uphill in the one that the line search goes by.
                let step = if self.slope(&step, &gradient) < 0.0 { &step } else { &plain };
                self.line_search(&now, step, &gradient, tolerance.motion)
            });
            self.profile.line_search += clock.elapsed().as_secs_f64();
            iterations += 1;
            self.profile.iterations += 1;
            match searched {
                // A step that rounding swallows: the state sits on a crease of the object, where no direction descends.
                Some((_, _, alpha)) if alpha < STUCK && residual > allowed => {
                    return Err(Failure::LineSearch(residual));
                }
                Some((next, motion, alpha)) => {
                    (now, last_motion) = (next, motion);
                    how = after_step(motion, alpha < WHOLE, tolerance);
                }
                // At rounding level no step lowers the energy any more: that is as converged as doubles get.
                None if residual <= allowed => {
                    last_motion = 0.0;
                    how = after_step(last_motion, how.secant, tolerance);
                }
                None => return Err(Failure::LineSearch(residual)),
            }
            how.follow = lagging.follows();
        }
    }

    /// Takes the step, as far as the largest motion of `tolerance` allows, if it lowers the `residual` (N). Returns as
    /// [`Newton::line_search`] does; the terms are assembled at the new state, or at `now` without their Hessians if the step is not
    /// taken.
    fn balance(
        &mut self,
        now: &State,
        step: &NewtonStep,
        residual: f64,
        tolerance: &NewtonTolerance,
    ) -> Option<(State, f64, f64)> {
        let clock = Instant::now();
        let motion = self.motion(step);
        let alpha = (tolerance.motion / motion.max(f64::MIN_POSITIVE)).min(1.0);
        let next = now.moved(&self.rigid, step, alpha);
        let how = after_step(alpha * motion, alpha < WHOLE, tolerance);
        self.assemble(&next, how);
        let (left, lag) = self.residual();
        let good = left.hypot(lag) < (1.0 - BALANCED * alpha) * residual;
        if !good {
            self.assemble_some(now, how, false);
        }
        self.profile.assembly += clock.elapsed().as_secs_f64();
        good.then_some((next, alpha * motion, alpha))
    }

    /// Backtracks from the whole step until the energy falls (Armijo). Returns the new state, its largest
    /// motion (m, at most `cap`) and the fraction taken; None if no step lowers the energy.
    fn line_search(
        &self,
        now: &State,
        step: &NewtonStep,
        rigid: &[f64; MAX_RIGID],
        cap: f64,
    ) -> Option<(State, f64, f64)> {
        let motion = self.motion(step);
        let slope = self.slope(step, rigid);
        if !motion.is_finite() || !slope.is_finite() {
            return None;
        }
        let start = self.energy(now);
        let mut alpha = (cap / motion.max(f64::MIN_POSITIVE)).min(1.0);
        for trial in 0..30 {
            let next = now.moved(&self.rigid, step, alpha);
            let energy = self.energy(&next);
            // Rounding of the sum over elements is about 1e-14 of the energy.
            if energy <= start + 1e-4 * alpha * slope + 1e-14 * start.abs() {
                return Some((next, alpha * motion, alpha));
            }
            alpha *= if trial < 2 { 0.5 } else { 0.25 };
        }
        None
    }
}

/// Returns how terms are assembled after a step of length `motion` (m). Friction bends the energy where points begin to slip: a step that
/// crosses it far is `cut`, and the next one is more careful.
fn after_step(motion: f64, cut: bool, tolerance: &NewtonTolerance) -> Assembly {
    Assembly { project: false, follow: true, sharp: motion <= SHARP_MOTION * tolerance.offset, secant: cut }
}
