//! Load increments that adapt: predict, solve, accept; or roll back, halve and try again; or walk.

use super::newton::{Converged, Failure, Newton, Tolerance};
use super::state::State;

/// A quasi-static loading path: solver, accepted state, and the history its predictor needs.
pub struct Path {
    /// The solver with its terms.
    pub newton: Newton,
    /// The last accepted state.
    pub state: State,
    /// Load level of `state`: force per finger (N) or prescribed travel (m), whatever [`Load`] says.
    pub level: f64,
    /// Convergence criteria.
    pub tolerance: Tolerance,
    /// Motion of the object in one walk at which it counts as lost, m; None follows it however far it goes.
    pub leash: Option<f64>,
    /// Motion of the object after which a walk halts on its way, m; None walks on to where the object rests.
    pub stage: Option<f64>,
    /// A walk has halted in `state`, which is no equilibrium: the next one goes on there.
    pub(super) underway: bool,
    /// The accepted state before `state`, with its level.
    pub(super) history: Option<(State, f64)>,
    /// Increment that worked last.
    increment: f64,
    /// Iterations of walks and of increments that failed.
    spent: u32,
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

impl Advanced {
    /// Adds what followed.
    pub fn add(&mut self, more: Advanced) {
        self.iterations += more.iterations;
        self.increments += more.increments;
        if more.increments > 0 {
            self.residual = more.residual;
        }
    }

    pub(super) fn accept(&mut self, converged: Converged) {
        self.iterations += converged.iterations;
        self.increments += 1;
        self.residual = converged.residual;
    }
}

/// How a load level acts on solver and state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Load {
    /// The level is the force on every finger, N.
    Force,
    /// The level is the travel of every finger since the start, m.
    Travel,
}

/// Smallest increment as a fraction of the one asked for: of a path with nothing but bodies, and of one that can walk.
const SMALLEST: [f64; 2] = [1.0 / 4096.0, 1.0 / 8.0];
/// Largest increment of a force over the force reached.
const GROWTH: f64 = 3.0;
/// How much looser intermediate states may be than results.
pub(super) const LOOSE: f64 = 20.0;
/// Iterations that walks and failed increments may take before the path is given up.
const ENDURANCE: u32 = 4000;

impl Path {
    /// Starts at `state`, which must be in equilibrium at level zero.
    pub fn new(newton: Newton, state: State, tolerance: Tolerance) -> Self {
        Self {
            newton,
            state,
            level: 0.0,
            tolerance,
            leash: None,
            stage: None,
            underway: false,
            history: None,
            increment: f64::INFINITY,
            spent: 0,
        }
    }

    /// True once so much was spent on walks and on increments that failed that the next failure ends the path.
    pub fn exhausted(&self) -> bool {
        self.spent >= ENDURANCE
    }

    /// A level was reached: half of what was spent is forgiven.
    pub fn recover(&mut self) {
        self.spent /= 2;
    }

    /// Brings the fingers from first touch to the small force `force` (N): around an object that is held where it is, and is then
    /// let go. Touched by single points it would have next to no stiffness against rotation, and turn to wherever a solver takes it;
    /// between patches that stick it moves as little as these give.
    ///
    /// # Errors
    /// The last [`Failure`]; the state is then that of the start, or that in which the object was held.
    pub fn establish(&mut self, force: f64) -> Result<Advanced, Failure> {
        // A stepping stone, not a result: nobody needs it sharp. `advance` or `polish` come next.
        let sharp = self.tolerance;
        self.tolerance.relative *= LOOSE;
        self.newton.force.fill(force);
        self.newton.held = true;
        let mut done = Advanced::default();
        let closed = self.settle(self.state.clone(), true, &mut done);
        self.newton.held = false;
        let rests = match closed {
            Ok(()) if self.newton.border.pose.is_some() => self.settle(self.state.clone(), true, &mut done),
            closed => closed,
        };
        self.tolerance = sharp;
        rests?;
        (self.level, self.history) = (force, None);
        Ok(done)
    }

    /// Solves once more at the level reached, to the full tolerance.
    ///
    /// # Errors
    /// The [`Failure`]; the state stays as it was, or after [`Failure::Underway`] is where the walk halted.
    pub fn polish(&mut self) -> Result<Advanced, Failure> {
        let mut done = Advanced::default();
        self.settle(self.state.clone(), true, &mut done).map(|()| done)
    }

    /// Raises the load to `target` in as few increments as converge; at `target` already, finds the equilibrium there once more.
    ///
    /// # Errors
    /// The last [`Failure`] when even the smallest increment does not converge. State, history and level are then those
    /// of the last accepted increment.
    pub fn advance(&mut self, load: Load, target: f64) -> Result<Advanced, Failure> {
        // The same force under another load on the object is another equilibrium.
        if self.level == target {
            return self.polish();
        }
        let whole = target - self.level;
        let walks = self.newton.border.size > 0;
        // An object on a leash is followed at once: smaller increments would only find out later that it slides.
        let smallest = whole.abs() * if self.leash.is_some() { 1.0 } else { SMALLEST[usize::from(walks)] };
        // An increment that the way to a level close by needed says little of the way to one far off.
        let mut step = whole.abs().min(self.increment.max(smallest));
        let mut done = Advanced::default();
        while (target - self.level).abs() > 1e-12 * target.abs() {
            let rest = target - self.level;
            // From a small load on, contact spreads fast: a load many times as large is not near.
            let near = if load == Load::Force && self.level > 0.0 { GROWTH * self.level } else { f64::INFINITY };
            let size = step.min(rest.abs()).min(near);
            let next = if size >= rest.abs() { target } else { self.level + size * rest.signum() };
            let last_resort = 0.5 * size < smallest || self.exhausted();
            if load == Load::Force {
                self.newton.force.fill(next);
            }
            let before = (self.state.clone(), self.level);
            let cost = done.iterations;
            let start = self.start(load, next);
            match self.settle(start, last_resort && walks, &mut done) {
                Ok(()) => {
                    self.history = Some(before);
                    self.level = next;
                    step = size * if done.iterations - cost < 15 { 2.0 } else { 1.0 };
                    // Remember an increment only if the path itself forced it to be small.
                    self.increment = if step >= whole.abs() { f64::INFINITY } else { step };
                }
                Err(failure) if last_resort || failure.is_out_of_effort() => {
                    if load == Load::Force {
                        self.newton.force.fill(self.level);
                    }
                    return Err(failure);
                }
                Err(_) => step = 0.5 * size,
            }
        }
        Ok(done)
    }

    /// Solves from `start` and accepts the result; if that fails and `walk` is set, walks there from the accepted state.
    fn settle(&mut self, start: State, walk: bool, done: &mut Advanced) -> Result<(), Failure> {
        if !std::mem::take(&mut self.underway) {
            let failure = match self.newton.solve(&self.state, start, &self.tolerance) {
                Ok((state, converged)) => {
                    self.newton.commit(&state);
                    self.state = state;
                    done.accept(converged);
                    return Ok(());
                }
                Err(failure) => failure,
            };
            self.newton.rollback();
            done.iterations += self.tolerance.iterations;
            self.spent += self.tolerance.iterations;
            if !walk || self.newton.border.size == 0 || self.exhausted() || failure.is_out_of_effort() {
                return Err(failure);
            }
        }
        let saved = self.newton.save();
        let before = done.iterations;
        let walked = self.walk(done);
        self.spent += done.iterations - before;
        self.newton.proximal = None;
        match walked {
            Ok(state) => {
                self.state = state;
                self.history = None;
                Ok(())
            }
            Err(failure) => {
                if failure != Failure::Underway {
                    self.newton.terms = saved;
                }
                Err(failure)
            }
        }
    }

    /// Where to start the increment to `level`, under whose load the solver is: extrapolated from the last two accepted
    /// states. The prediction may overshoot, into deep contact or infeasible territory; then it is the accepted state.
    fn start(&self, load: Load, level: f64) -> State {
        let mut plain = self.state.clone();
        if load == Load::Travel {
            plain.travel.iter_mut().for_each(|t| *t = *t + level - self.level);
        }
        let Some((before, at)) = &self.history else { return plain };
        let factor = (level - self.level) / (self.level - at);
        let near = factor > 0.0 && factor <= 2.0;
        if !near {
            return plain;
        }
        let mut predicted = self.state.extrapolated(before, factor);
        match load {
            Load::Travel => predicted.travel.clone_from(&plain.travel),
            Load::Force => plain.travel.clone_from(&predicted.travel),
        }
        let worse = self.newton.energy(&predicted).total_cmp(&self.newton.energy(&plain)).is_gt();
        if worse { plain } else { predicted }
    }
}
