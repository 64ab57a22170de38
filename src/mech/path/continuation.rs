//! Continuation of the load in increments, and the methods that are tried if one fails.
//!
//! An attempt at a level is accepted, or the increment is reduced, or the method changes:
//!
//! | outcome of an attempt | response |
//! |---|---|
//! | path error too large | smaller increment, by the error (`step_size.rs`) |
//! | no equilibrium | half the increment, with proximal springs, or stiffer ones (`pseudo_time.rs`) |
//! | no equilibrium under a push | bisection to a thousandth; then slip or end of the grasp (`backend/fem/level.rs`) |
//! | condensed pads fail | full pads, from the last accepted level (`backend/fem/level.rs`) |
//! | the object left the grasp, or no effort is left | end of the grasp |
//! | no equilibrium in a time step (`backend/fem/dynamics/integrator.rs`) | half, down to 1/64 of the scene's step |
//!
//! [`MethodCounts`] counts how often each was needed.

pub use super::methods::MethodCounts;
use super::pseudo_time::LOOSE_TOLERANCE_FACTOR;
use super::step_size::StepSize;
use super::{AdvanceCost, Load, Path};
use crate::newton::Failure;
use base::scales::LOST_CONTACT_MOTION;

/// Discretisation of the pads: operations of an attempt in addition to the equilibrium.
pub trait PadDiscretisation {
    /// Returns true if an attempt may fail after its equilibrium was accepted, and may change the discretisation of the
    /// pads.
    fn needs_checkpoint(&self) -> bool {
        false
    }
    /// Begins an attempt at `level`.
    fn predict(&mut self, _path: &mut Path, _level: f64) {}
    /// Corrects the equilibrium found at `level` to that of the full pads, within the full tolerance if it is a
    /// `result`.
    ///
    /// # Errors
    /// Fails if that equilibrium is not reached; the [`Failure`] gives the reason.
    fn correct(
        &mut self,
        _path: &mut Path,
        _level: f64,
        _result: bool,
        _done: &mut AdvanceCost,
    ) -> Result<(), Failure> {
        Ok(())
    }
    /// Corrects the pads once for their state at `level`, which is intermediate.
    ///
    /// # Errors
    /// Fails with [`Failure::Singular`] if the pads cannot be discretised again there.
    fn correct_once(&mut self, _path: &mut Path, _level: f64) -> Result<(), Failure> {
        Ok(())
    }
    /// Updates the pads after `path` was restored to the accepted state.
    fn restore(&mut self, _path: &mut Path) {}
}

/// Full (uncondensed) pad model: all nodes are unknowns.
pub struct FullPads;

impl PadDiscretisation for FullPads {}

/// Maximum number of consecutive failed attempts.
const MAX_FAILED_ATTEMPTS: u32 = 16;
/// Distance between the accepted push and one without equilibrium, over the target push, below which the accepted one
/// counts as the largest that the grasp can bear. Increments this small distinguish an object that slips from one that
/// rolls on: at a hundredth, an ellipsoid counts as lost at nine tenths of the push that it can bear.
const PUSH_LIMIT_ERROR: f64 = 0.001;
/// Largest increment of a force over the current force.
const FORCE_GROWTH: f64 = 3.0;
/// Increment of a force over the current force while no error is known. A Hertz (1882) contact, whose depth grows with
/// the power 2/3 of the force, deviates there from its secant by 2 % of the displacement: the path error is of this
/// order.
const FIRST_FORCE_GROWTH: f64 = 0.25;

/// Result of an attempt.
struct Attempt {
    /// Error of the increment over the error allowed.
    error: f64,
    /// Flag: the state is an equilibrium.
    is_equilibrium: bool,
}

impl Path {
    /// Raises the finger forces from first contact to the small `force` (N), around an object that is held fixed. An
    /// object in contact at single points would have almost no rotational stiffness and rotate arbitrarily; between
    /// contact patches that stick, it moves only as far as these deform.
    ///
    /// # Errors
    /// Returns the last [`Failure`]; the state is then that of the start.
    pub fn establish_contact(&mut self, force: f64) -> Result<AdvanceCost, Failure> {
        // The state is intermediate, so that the loose tolerance suffices; `advance` or `solve_tightly` follow.
        let tight = self.tolerance;
        self.tolerance.relative *= LOOSE_TOLERANCE_FACTOR;
        self.newton.force.fill(force);
        let level = std::mem::replace(&mut self.level, force);
        let closed = self.advance(Load::Force, force, &mut FullPads);
        self.tolerance = tight;
        self.previous = None;
        if closed.is_err() {
            self.level = level;
        }
        closed
    }

    /// Raises the load to `target` in as many increments as convergence and path error require; if it is at `target`
    /// already, finds the equilibrium there again. Load and pseudo-time advance together: where no equilibrium is
    /// found, springs bound the motion of an increment.
    ///
    /// # Errors
    /// Returns the last [`Failure`] when no method is left. State, history and level are then those of the last
    /// accepted increment.
    pub fn advance(
        &mut self,
        load: Load,
        target: f64,
        pads: &mut dyn PadDiscretisation,
    ) -> Result<AdvanceCost, Failure> {
        // Under a constant push, nothing stops an object that starts to move.
        let can_roll = self.newton.rigid.pose.is_some() && load != Load::Push;
        let (mut done, mut failures) = (AdvanceCost::default(), 0);
        let begins = self.state.clone();
        // Push without equilibrium that is nearest to the accepted one.
        let mut beyond = None;
        // Motion accumulated while a finger has no contact, m.
        let mut apart = 0.0;
        loop {
            let rest = target - self.level;
            let gap = beyond.map_or(f64::INFINITY, |push: f64| (push - self.level).abs());
            let smallest = PUSH_LIMIT_ERROR * target.abs();
            let near = gap <= smallest;
            let longest = self.longest_increment(load).min(0.5 * gap);
            let planned = match near {
                _ if self.pseudo_time.holds_load => 0.0,
                true => gap.copysign(rest),
                false => self.step_size.next(rest).clamp(-longest, longest),
            };
            let next = if planned.abs() >= rest.abs() { target } else { self.level + planned };
            let size = next - self.level;
            let cost = done.iterations;
            let failure = match self.attempt(load, next, next == target, pads, &mut done) {
                Ok((Attempt { error, is_equilibrium }, moved)) => {
                    self.methods.increments += 1;
                    if size != 0.0 {
                        let shortest =
                            self.control.map_or(0.0, |control| self.shortest_rated_increment(control.first_load));
                        self.step_size.accept(size, done.iterations - cost, error, shortest);
                        if self.control.is_some() && load == Load::Force && self.step_size == StepSize::UNKNOWN {
                            self.step_size = StepSize(FIRST_FORCE_GROWTH * next);
                        }
                    }
                    failures = 0;
                    beyond = beyond.filter(|_| !near);
                    apart = if self.newton.lacks_contact() { apart + moved } else { 0.0 };
                    let way = self.newton.rigid.distance(&self.state, &begins);
                    match () {
                        _ if apart >= LOST_CONTACT_MOTION * self.tolerance.offset => return Err(Failure::LostContact),
                        _ if self.largest_drift.is_some_and(|most| way > most) => return Err(Failure::MovedTooFar),
                        _ if self.grasp_limits.is_some_and(|limits| limits.is_exceeded(&self.state)) => {
                            return Err(Failure::MovedTooFar);
                        }
                        _ if next == target && is_equilibrium => return Ok(done),
                        _ if self.exhausted() => return Err(Failure::Unsettled),
                        _ => continue,
                    }
                }
                Err(failure) => failure,
            };
            failures += 1;
            match failure {
                Failure::MovedTooFar => return Err(failure),
                _ if failure.is_out_of_effort() => return Err(failure),
                Failure::PathError(error) => {
                    self.methods.rejected += 1;
                    self.step_size.reject(size, Some(error));
                }
                _ if failures > MAX_FAILED_ATTEMPTS || self.exhausted() => return Err(failure),
                // No parameter is left to change.
                _ if load == Load::Push && planned.abs() <= smallest => return Err(failure),
                _ if size == 0.0 && !can_roll => return Err(failure),
                Failure::LostContact if self.pseudo_time.is_on() => return Err(failure),
                _ => {
                    self.methods.halved += 1;
                    beyond = (load == Load::Push).then_some(next);
                    if size != 0.0 {
                        self.step_size.reject(size, None);
                    }
                    if can_roll {
                        self.methods.pseudo_transient += u64::from(!self.pseudo_time.is_on());
                        self.pseudo_time.reject(self.driving_force(), &self.tolerance);
                    }
                }
            }
        }
    }

    /// Makes one attempt at level `next`, which is a `result` or intermediate. Returns its outcome, and the motion of
    /// the rigid unknowns, m.
    fn attempt(
        &mut self,
        load: Load,
        next: f64,
        result: bool,
        pads: &mut dyn PadDiscretisation,
        done: &mut AdvanceCost,
    ) -> Result<(Attempt, f64), Failure> {
        let saved = pads.needs_checkpoint().then(|| self.checkpoint());
        pads.predict(self, next);
        self.apply_load(load, next);
        let before = (self.state.clone(), self.level);
        self.newton.proximal = self.pseudo_time.springs(&self.state);
        let start = self.initial_guess(load, next);
        let to = (next != self.level).then_some(next);
        let tolerance = self.pseudo_time.tolerance(&self.tolerance);
        let floor = self.tolerance.force.max(self.tolerance.relative * self.driving_force());
        let attempt = self.equilibrate(start, to, &tolerance, done).and_then(|(error, moved)| {
            let is_equilibrium = self.pseudo_time.is_equilibrium(moved.spring_force, floor);
            match result && is_equilibrium || !self.pseudo_time.is_on() {
                true => pads.correct(self, next, result, done)?,
                false => pads.correct_once(self, next)?,
            }
            Ok((Attempt { error, is_equilibrium }, moved))
        });
        self.newton.proximal = None;
        match attempt {
            Ok((attempt, moved)) => {
                let (load, full) = (self.driving_force(), self.tolerance);
                // At constant load, the two states do not give the direction of the path.
                self.previous = to.map(|_| before).filter(|_| !self.pseudo_time.holds_load);
                self.pseudo_time.accept(&moved, load, floor, &full, to.is_some());
                self.level = next;
                Ok((attempt, moved.motion))
            }
            Err(failure) => {
                self.apply_load(load, self.level);
                if let Some(saved) = saved {
                    self.restore(saved);
                    pads.restore(self);
                }
                Err(failure)
            }
        }
    }

    /// Force that drives the rigid unknowns, N.
    fn driving_force(&self) -> f64 {
        let forces = self.newton.force.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        forces.max(self.tolerance.force / self.tolerance.relative)
    }

    /// Longest increment from the accepted state.
    fn longest_increment(&self, load: Load) -> f64 {
        // Contact spreads fast at small loads: a load many times as large is out of reach.
        let near = if load == Load::Force && self.level > 0.0 { FORCE_GROWTH * self.level } else { f64::INFINITY };
        match self.control {
            // The direction of the path is not known yet.
            Some(control) if self.previous.is_none() => near.min(control.first_load.max(self.level)),
            _ => near,
        }
    }
}
