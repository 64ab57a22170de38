//! Newton's method with line search on the incremental potential.

use super::lagging::Lagging;
use super::{Converged, Failure, Newton, NewtonTolerance};
use crate::potential::state::{MAX_RIGID, NewtonStep, State};
use crate::potential::term::Assembly;
use base::scales::COMPLETE_HESSIAN_MOTION;
use std::time::Instant;

/// Largest step of the rigid unknowns in one iteration, as a fraction of the largest motion.
const RIGID_STEP_FRACTION: f64 = 0.2;
/// Smallest relative decrease of the residual in a full step with friction that follows the pressure.
const RESIDUAL_DECREASE: f64 = 0.1;
/// Fraction of a step from which it counts as full.
const FULL_STEP_FRACTION: f64 = 0.9;
/// Fraction of a step below which it is lost in rounding.
const SMALLEST_STEP_FRACTION: f64 = 1e-9;

impl Newton {
    /// Minimises the potential from `start`, in an increment that starts from the accepted state `from`.
    ///
    /// # Errors
    /// Returns the [`Failure`]; the terms' history is unchanged, so that a smaller increment can be tried.
    pub fn solve(
        &mut self,
        from: &State,
        start: State,
        tolerance: &NewtonTolerance,
    ) -> Result<(State, Converged), Failure> {
        self.begin_increment(from);
        let mut now = start;
        let mut last_motion = f64::INFINITY;
        let mut iterations = 0;
        let mut lagging = Lagging::new(tolerance.intermediate);
        let (mut how, mut assembled) = (after_step(last_motion, false, tolerance), false);
        loop {
            self.profile.frozen += u64::from(lagging.becomes_lagged());
            let clock = Instant::now();
            if !assembled {
                self.assemble(&now, how);
            }
            self.profile.assembly += clock.elapsed().as_secs_f64();
            let (residual, lag) = self.residual();
            if !residual.is_finite() {
                return Err(Failure::Singular);
            }
            let allowed = tolerance.force + tolerance.relative * self.force_scale();
            lagging.record(residual, lag, allowed);
            let residual = lagging.out_of_balance(residual, lag);
            let balanced = residual <= allowed && (last_motion <= tolerance.length || residual <= 0.01 * allowed);
            if balanced && self.enforce_constraints(&now) {
                return Ok((now, Converged { iterations, residual }));
            }
            if iterations >= tolerance.iterations {
                return Err(Failure::Iterations(residual));
            }
            if balanced {
                last_motion = f64::INFINITY;
                iterations += 1;
                how = Assembly {
                    update_friction: lagging.updates_friction(),
                    ..after_step(last_motion, how.secant, tolerance)
                };
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
            let cap = RIGID_STEP_FRACTION * tolerance.max_motion;
            let (plain, gradient) = self.direction(cap);
            let step =
                if how.update_friction { self.correct_direction(&now, &plain, &gradient, cap) } else { plain.clone() };
            self.profile.solve += clock.elapsed().as_secs_f64();
            // Friction that follows the pressure has no potential: its step is accepted if it reduces the residual.
            let balanced = if how.update_friction { self.try_step(&now, &step, residual, tolerance) } else { None };
            assembled = balanced.is_some() && lagging.updates_friction();
            let clock = Instant::now();
            let searched = balanced.or_else(|| {
                // The nonsymmetric step may be an ascent direction of the energy that the line search uses.
                let step = if self.slope(&step, &gradient) < 0.0 { &step } else { &plain };
                self.line_search(&now, step, &gradient, tolerance.max_motion)
            });
            self.profile.line_search += clock.elapsed().as_secs_f64();
            iterations += 1;
            self.profile.iterations += 1;
            match searched {
                // The step is lost in rounding: the state lies on a non-smooth ridge of the object, where no direction
                // descends.
                Some((_, _, alpha)) if alpha < SMALLEST_STEP_FRACTION && residual > allowed => {
                    return Err(Failure::LineSearch(residual));
                }
                Some((next, motion, alpha)) => {
                    (now, last_motion) = (next, motion);
                    how = after_step(motion, alpha < FULL_STEP_FRACTION, tolerance);
                }
                // No step lowers the energy by more than rounding: the state has converged to double precision.
                None if residual <= allowed => {
                    last_motion = 0.0;
                    how = after_step(last_motion, how.secant, tolerance);
                }
                None => return Err(Failure::LineSearch(residual)),
            }
            how.update_friction = lagging.updates_friction();
        }
    }

    /// Takes the step, limited to the largest motion of `tolerance`, if it lowers the `residual` (N). Returns the same
    /// as [`Newton::line_search`]; the terms are then assembled at the new state or, if the step is rejected, at `now`
    /// without their Hessians.
    fn try_step(
        &mut self,
        now: &State,
        step: &NewtonStep,
        residual: f64,
        tolerance: &NewtonTolerance,
    ) -> Option<(State, f64, f64)> {
        let clock = Instant::now();
        let motion = self.step_motion_bound(step);
        let alpha = (tolerance.max_motion / motion.max(f64::MIN_POSITIVE)).min(1.0);
        let next = now.moved(&self.rigid, step, alpha);
        let how = after_step(alpha * motion, alpha < FULL_STEP_FRACTION, tolerance);
        self.assemble(&next, how);
        let (left, lag) = self.residual();
        let good = left.hypot(lag) < (1.0 - RESIDUAL_DECREASE * alpha) * residual;
        if !good {
            self.assemble_some(now, how, false);
        }
        self.profile.assembly += clock.elapsed().as_secs_f64();
        good.then_some((next, alpha * motion, alpha))
    }

    /// Backtracks from the full step until the energy decreases (Armijo). Returns the new state, its largest motion (m,
    /// at most `cap`) and the fraction taken; None if no step lowers the energy.
    fn line_search(
        &self,
        now: &State,
        step: &NewtonStep,
        rigid: &[f64; MAX_RIGID],
        cap: f64,
    ) -> Option<(State, f64, f64)> {
        let motion = self.step_motion_bound(step);
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

/// Returns the assembly options after a step of length `motion` (m). Where points begin to slip, the curvature of the
/// friction energy drops abruptly: after a step that was `cut` there, the next one uses the secant.
fn after_step(motion: f64, cut: bool, tolerance: &NewtonTolerance) -> Assembly {
    Assembly {
        project: false,
        update_friction: true,
        complete_hessian: motion <= COMPLETE_HESSIAN_MOTION * tolerance.offset,
        secant: cut,
    }
}
