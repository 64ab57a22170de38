//! Quasi-static loading path: the accepted state, and the way to the next one.

pub mod checkpoint;
pub mod continuation;
pub mod grasp_place;
mod path_error;
mod pseudo_time;
pub mod step_size;

use self::continuation::{Methods, WholePads};
use self::grasp_place::GraspPlace;
use self::pseudo_time::{PseudoStep, PseudoTime};
use self::step_size::{REFUSED, StepSize};
use super::newton::{Converged, Failure, Newton, NewtonTolerance};
use super::potential::state::State;

/// Quasi-static loading path: solver, accepted state, and the history that its predictor needs.
/// [`Path::advance`](self::continuation) goes along it.
pub struct Path {
    /// The solver with its terms.
    pub newton: Newton,
    /// The last accepted state.
    pub state: State,
    /// Load level of `state`: force per finger (N), prescribed travel (m) or part of a push, whatever [`Load`] says.
    pub level: f64,
    /// Convergence criteria.
    pub tolerance: NewtonTolerance,
    /// Largest bend of the path away from a straight increment, over the displacement, and the load with which the path begins
    /// (N or m); None where the answer does not depend on the path.
    pub control: Option<PathControl>,
    /// Motion of the object on the way to one level at which it counts as lost, m; None follows it however far it goes.
    pub largest_drift: Option<f64>,
    /// Place that the object may not leave; None follows it wherever it goes.
    pub place: Option<GraspPlace>,
    /// Counts of how often each method was used.
    pub methods: Methods,
    /// The accepted state before `state`, with its level.
    pub(crate) history: Option<(State, f64)>,
    /// Size of the next increment.
    pub(crate) step: StepSize,
    /// Springs of the next increment.
    pub(crate) pseudo_time: PseudoTime,
    /// Iterations of steps in pseudo-time and of increments that failed.
    spent: u32,
}

/// Control of the increments where friction makes the answer depend on the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathControl {
    /// Largest bend of the path away from a straight increment, over the displacement.
    pub bend: f64,
    /// The load with which the path begins, N or m.
    pub first: f64,
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
    /// Adds the cost of what followed.
    pub fn add(&mut self, more: Advanced) {
        self.iterations += more.iterations;
        self.increments += more.increments;
        if more.increments > 0 {
            self.residual = more.residual;
        }
    }

    pub(crate) fn accept(&mut self, converged: Converged) {
        self.iterations += converged.iterations;
        self.increments += 1;
        self.residual = converged.residual;
    }
}

/// Kind of load: how a level acts on solver and state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Load {
    /// The level is the force on every finger, N.
    Force,
    /// The level is the travel of every finger since the start, m.
    Travel,
    /// The level is the part of the push on the object that acts.
    Push,
}

/// Tolerance of intermediate states over that of results.
pub(crate) const LOOSE: f64 = 20.0;
/// Iterations that steps in pseudo-time and failed increments may take before the path is given up.
const ENDURANCE: u32 = 4000;

impl Path {
    /// Starts at `state`, which must be in equilibrium at level zero.
    pub fn new(newton: Newton, state: State, tolerance: NewtonTolerance) -> Self {
        Self {
            newton,
            state,
            level: 0.0,
            tolerance,
            control: None,
            largest_drift: None,
            place: None,
            methods: Methods::default(),
            history: None,
            step: StepSize::UNKNOWN,
            pseudo_time: PseudoTime::NONE,
            spent: 0,
        }
    }

    /// Returns true once so much was spent on pseudo-transient continuations and on increments that failed that the next
    /// failure ends the path.
    pub fn exhausted(&self) -> bool {
        self.spent >= ENDURANCE
    }

    /// Forgives half of what was spent, since a level was reached.
    pub fn recover(&mut self) {
        self.spent /= 2;
    }

    /// Brings the fingers from first touch to the small force `force` (N), around an object that is held where it is. An object
    /// touched at single points would have next to no stiffness against rotation and turn to wherever a solver takes it;
    /// between patches that stick it moves as little as these give.
    ///
    /// # Errors
    /// The last [`Failure`]; the state is then that of the start.
    pub fn establish(&mut self, force: f64) -> Result<Advanced, Failure> {
        // A stepping stone, not a result: nobody needs it sharp. `advance` or `polish` come next.
        let sharp = self.tolerance;
        self.tolerance.relative *= LOOSE;
        self.newton.force.fill(force);
        let level = std::mem::replace(&mut self.level, force);
        let closed = self.advance(Load::Force, force, &mut WholePads);
        self.tolerance = sharp;
        self.history = None;
        if closed.is_err() {
            self.level = level;
        }
        closed
    }

    /// Begins another kind of load, which is zero in the accepted state; its path begins with the load `first`.
    pub fn begin_load(&mut self, first: f64) {
        (self.level, self.history, self.step) = (0.0, None, StepSize::UNKNOWN);
        self.control = self.control.map(|control| PathControl { first, ..control });
    }

    /// Sets the load that acts in the solver to `level`.
    fn apply(&mut self, load: Load, level: f64) {
        match load {
            Load::Force => self.newton.force.fill(level),
            Load::Push => self.newton.object.set_push_part(level),
            Load::Travel => {}
        }
    }

    /// Solves once more in the state reached, to the full tolerance.
    ///
    /// # Errors
    /// The [`Failure`]; the state stays as it was.
    pub fn polish(&mut self) -> Result<Advanced, Failure> {
        let (mut done, tolerance) = (Advanced::default(), self.tolerance);
        self.equilibrate(self.state.clone(), None, &tolerance, &mut done).map(|_| done)
    }

    /// Solves from `start`, which is at level `to` if that is another one, and accepts the result. Returns the error of the increment over
    /// the error allowed, and what came of it.
    fn equilibrate(
        &mut self,
        start: State,
        to: Option<f64>,
        tolerance: &NewtonTolerance,
        done: &mut Advanced,
    ) -> Result<(f64, PseudoStep), Failure> {
        match self.newton.solve(&self.state, start, tolerance) {
            Ok((state, converged)) => {
                let springs = self.newton.proximal.as_ref();
                // Springs bound the motion of an increment in the place of its bend.
                let error = to.filter(|_| springs.is_none()).map_or(0.0, |to| self.bend(&state, to));
                if error > REFUSED {
                    self.newton.rollback();
                    done.iterations += converged.iterations;
                    return Err(Failure::Bent(error));
                }
                let pull = springs.map_or(0.0, |springs| springs.pull(&self.newton, &state));
                let way = self.newton.rigid.distance(&state, &self.state);
                self.spent += if springs.is_some() { converged.iterations } else { 0 };
                self.newton.commit(&state);
                self.state = state;
                done.accept(converged);
                Ok((error, PseudoStep { iterations: converged.iterations, way, pull }))
            }
            Err(failure) => {
                self.newton.rollback();
                done.iterations += tolerance.iterations;
                self.spent += tolerance.iterations;
                Err(failure)
            }
        }
    }

    /// Returns the start state of the increment to `level`, under whose load the solver is: extrapolated from the last two
    /// accepted states. A prediction that overshoots, into deep contact or infeasible territory, is replaced by the accepted
    /// state.
    pub(crate) fn start(&self, load: Load, level: f64) -> State {
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
            Load::Force | Load::Push => plain.travel.clone_from(&predicted.travel),
        }
        let worse = self.newton.energy(&predicted).total_cmp(&self.newton.energy(&plain)).is_gt();
        if worse { plain } else { predicted }
    }
}
