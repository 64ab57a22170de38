//! Load increments that adapt: predict, solve, accept; or roll back, halve and try again.

use super::newton::{Converged, Failure, Newton, Tolerance};
use super::state::State;

/// A quasi-static loading path: solver, accepted state, and the history its predictor needs.
pub struct Path {
    /// The solver with its terms.
    pub newton: Newton,
    /// The last accepted state.
    pub state: State,
    /// Load level of `state`: force per finger (N) or prescribed travel (m), whatever `apply` sets.
    pub level: f64,
    /// Convergence criteria.
    pub tolerance: Tolerance,
    /// The accepted states before `state`, newest last, with their levels.
    history: Vec<(State, f64)>,
    /// Increment that worked last.
    increment: f64,
}

/// Cost of one advance.
#[derive(Debug, Clone, Copy, Default)]
pub struct Advanced {
    /// Newton iterations, failed increments included.
    pub iterations: u32,
    /// Accepted increments.
    pub increments: u32,
    /// Residual of the last one, N.
    pub residual: f64,
}

/// How a load level acts on solver and state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Load {
    /// The level is the force on every finger, N.
    Force,
    /// The level is the travel of every finger beyond `base`, m.
    Travel,
}

/// Softness of the contact when the fingers first touch.
pub const SOFTEST: f64 = 1000.0;

/// Smallest increment, as a fraction of the one asked for.
const SMALLEST: f64 = 1.0 / 4096.0;

impl Path {
    /// Starts at `state`, which must be in equilibrium at level zero.
    pub fn new(newton: Newton, state: State, tolerance: Tolerance) -> Self {
        Self { newton, state, level: 0.0, tolerance, history: Vec::new(), increment: f64::INFINITY }
    }

    /// Brings the fingers from first touch to equilibrium under the small force `force` (N), by continuation from a soft,
    /// far-reaching contact to the contact law itself. A free object touched by single points has no stiffness against
    /// rotation; the soft contact gives it some, and the hardening keeps it.
    ///
    /// `state` must stand [`SOFTEST`]-softened offsets away from the object.
    ///
    /// # Errors
    /// The last [`Failure`]; the state is then that of the last softness that converged.
    pub fn establish(&mut self, force: f64, offset: f64) -> Result<Advanced, Failure> {
        self.newton.force.fill(force);
        let mut done = Advanced::default();
        let mut softness = SOFTEST;
        let mut ratio = 10.0_f64;
        let mut reached = SOFTEST * ratio;
        loop {
            self.newton.soften(softness);
            let mut state = self.state.clone();
            if reached <= SOFTEST {
                // The surfaces that carry the contact have moved back towards the object: follow them.
                let closer = offset * (reached.sqrt() - softness.sqrt());
                state.travel.iter_mut().for_each(|t| *t += closer);
            }
            match self.newton.solve(&mut state, &self.tolerance) {
                Ok(converged) => {
                    self.newton.commit(&state);
                    self.state = state;
                    done.iterations += converged.iterations;
                    done.increments += 1;
                    done.residual = converged.residual;
                    reached = softness;
                    if softness <= 1.0 {
                        self.level = force;
                        return Ok(done);
                    }
                }
                Err(failure) => {
                    self.newton.rollback();
                    done.iterations += self.tolerance.iterations;
                    ratio = ratio.sqrt();
                    if ratio < 1.02 || reached > SOFTEST {
                        return Err(failure);
                    }
                }
            }
            softness = (reached / ratio).max(1.0);
        }
    }

    /// Raises the load to `target` in as few increments as converge.
    ///
    /// # Errors
    /// The last [`Failure`] when even the smallest increment does not converge. State, history and level are then those
    /// of the last accepted increment.
    pub fn advance(&mut self, load: Load, target: f64) -> Result<Advanced, Failure> {
        let whole = target - self.level;
        let smallest = whole.abs() * SMALLEST;
        let mut step = whole.abs().min(self.increment);
        let mut done = Advanced::default();
        while (target - self.level).abs() > 1e-12 * target.abs() {
            let rest = target - self.level;
            let (size, last) = if step >= rest.abs() { (rest.abs(), true) } else { (step, false) };
            let next = if last { target } else { self.level + size * rest.signum() };
            match self.attempt(load, next) {
                Ok((state, converged)) => {
                    self.newton.commit(&state);
                    done.iterations += converged.iterations;
                    done.increments += 1;
                    done.residual = converged.residual;
                    self.history.push((std::mem::replace(&mut self.state, state), self.level));
                    if self.history.len() > 2 {
                        self.history.remove(0);
                    }
                    self.level = next;
                    step = size * if converged.iterations < 12 { 2.0 } else { 1.0 };
                    // Remember an increment only if the path itself forced it to be small.
                    self.increment = if step >= whole.abs() { f64::INFINITY } else { step };
                }
                Err((failure, iterations)) => {
                    self.newton.rollback();
                    done.iterations += iterations;
                    step = 0.5 * size;
                    if step < smallest {
                        return Err(failure);
                    }
                }
            }
        }
        Ok(done)
    }

    /// One increment, from the extrapolated state first, from the accepted one if that fails.
    fn attempt(&mut self, load: Load, level: f64) -> Result<(State, Converged), (Failure, u32)> {
        if load == Load::Force {
            self.newton.force.fill(level);
        }
        let start = |base: &State| {
            let mut state = base.clone();
            if load == Load::Travel {
                state.travel.iter_mut().zip(&self.state.travel).for_each(|(t, now)| *t = now + level - self.level);
            }
            state
        };
        let mut state = start(&self.predicted(level));
        // A prediction may overshoot into infeasible territory; the accepted state never does.
        if !self.newton.energy(&state).is_finite() {
            state = start(&self.state);
        }
        match self.newton.solve(&mut state, &self.tolerance) {
            Ok(converged) => Ok((state, converged)),
            Err(failure) => Err((failure, self.tolerance.iterations)),
        }
    }

    /// Extrapolation of the last accepted states to `level`: quadratic from three, linear from two.
    fn predicted(&self, level: f64) -> State {
        let Some((before, at)) = self.history.last() else { return self.state.clone() };
        let factor = (level - self.level) / (self.level - at);
        if !(factor > 0.0 && factor <= 2.0) {
            return self.state.clone();
        }
        self.state.extrapolated(before, factor)
    }
}
