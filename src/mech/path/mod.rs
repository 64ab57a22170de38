//! Quasi-static loading path: the accepted state, and the increment to the next one.

pub mod checkpoint;
pub mod continuation;
mod cost;
pub mod grasp_limits;
mod load;
mod methods;
mod path_error;
mod pseudo_time;
pub mod step_size;

pub use self::cost::AdvanceCost;
use self::grasp_limits::GraspLimits;
pub use self::load::Load;
use self::methods::MethodCounts;
use self::pseudo_time::{PseudoStep, PseudoTime};
use self::step_size::{REJECTED_PATH_ERROR, StepSize};
use super::newton::{Failure, Newton, NewtonTolerance};
use super::potential::state::State;

/// Quasi-static loading path: solver, accepted state, and history of the predictor.
/// [`Path::advance`](self::continuation) raises the load.
pub struct Path {
    /// Solver with its terms.
    pub newton: Newton,
    /// Last accepted state.
    pub state: State,
    /// Load level of `state`: force per finger (N), prescribed travel (m) or fraction of a push, depending on [`Load`].
    pub level: f64,
    /// Convergence criteria.
    pub tolerance: NewtonTolerance,
    /// Largest path error and first load; None if the solution does not depend on the path.
    pub control: Option<PathControl>,
    /// Largest motion of the object within one advance, m, beyond which it counts as lost; None without limit.
    pub largest_drift: Option<f64>,
    /// Limits of the object's pose; None without limits.
    pub grasp_limits: Option<GraspLimits>,
    /// Counts of how often each method was used.
    pub methods: MethodCounts,
    /// Accepted state before `state`, with its level.
    pub previous: Option<(State, f64)>,
    /// Size of the next increment.
    pub(crate) step_size: StepSize,
    /// Proximal springs of the next increment.
    pub(crate) pseudo_time: PseudoTime,
    /// Iterations spent on pseudo-time steps and failed increments.
    spent_iterations: u32,
}

/// Control of the increments where friction makes the solution depend on the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathControl {
    /// Largest path error: deviation from a straight increment, over the displacement.
    pub max_path_error: f64,
    /// First load of the path, N or m.
    pub first_load: f64,
}

/// Maximum number of iterations of pseudo-time steps and failed increments before the path is given up.
const SPENT_ITERATIONS_LIMIT: u32 = 4000;

impl Path {
    /// Creates a path at `state`, which must be in equilibrium at level zero.
    pub fn new(newton: Newton, state: State, tolerance: NewtonTolerance) -> Self {
        Self {
            newton,
            state,
            level: 0.0,
            tolerance,
            control: None,
            largest_drift: None,
            grasp_limits: None,
            methods: MethodCounts::default(),
            previous: None,
            step_size: StepSize::UNKNOWN,
            pseudo_time: PseudoTime::NONE,
            spent_iterations: 0,
        }
    }

    /// Returns true once the iterations spent on pseudo-time steps and failed increments reach their limit: the path
    /// then ends unless it has reached its target.
    pub fn exhausted(&self) -> bool {
        self.spent_iterations >= SPENT_ITERATIONS_LIMIT
    }

    /// Halves the iterations spent, after a level was reached.
    pub fn halve_spent_iterations(&mut self) {
        self.spent_iterations /= 2;
    }

    /// Begins another kind of load, which is zero in the accepted state, with the `first_load`.
    pub fn begin_load(&mut self, first_load: f64) {
        (self.level, self.previous, self.step_size) = (0.0, None, StepSize::UNKNOWN);
        self.control = self.control.map(|control| PathControl { first_load, ..control });
    }

    /// Applies the load `level` to the solver.
    fn apply_load(&mut self, load: Load, level: f64) {
        match load {
            Load::Force => self.newton.force.fill(level),
            Load::Push => self.newton.object.set_push_fraction(level),
            Load::Travel => {}
        }
    }

    /// Solves again at the accepted state, to the full tolerance.
    ///
    /// # Errors
    /// Returns the [`Failure`]; the state is unchanged.
    pub fn solve_tightly(&mut self) -> Result<AdvanceCost, Failure> {
        let (mut done, tolerance) = (AdvanceCost::default(), self.tolerance);
        self.equilibrate(self.state.clone(), None, &tolerance, &mut done).map(|_| done)
    }

    /// Solves from `start`, at level `to` if the load changes, and accepts the result. Returns the path error over the
    /// error allowed, and the outcome of the step.
    fn equilibrate(
        &mut self,
        start: State,
        to: Option<f64>,
        tolerance: &NewtonTolerance,
        done: &mut AdvanceCost,
    ) -> Result<(f64, PseudoStep), Failure> {
        match self.newton.solve(&self.state, start, tolerance) {
            Ok((state, converged)) => {
                let springs = self.newton.proximal.as_ref();
                // Springs bound the motion of an increment, which replaces the bound on its path error.
                let error = to.filter(|_| springs.is_none()).map_or(0.0, |to| self.path_error(&state, to));
                if error > REJECTED_PATH_ERROR {
                    self.newton.rollback();
                    done.iterations += converged.iterations;
                    return Err(Failure::PathError(error));
                }
                let spring_force =
                    springs.map_or(0.0, |springs| springs.force(&self.newton.rigid, &self.newton.blocks, &state));
                let motion = self.newton.rigid.distance(&state, &self.state);
                self.spent_iterations += if springs.is_some() { converged.iterations } else { 0 };
                self.newton.commit(&state);
                self.state = state;
                done.accept(converged);
                Ok((error, PseudoStep { iterations: converged.iterations, motion, spring_force }))
            }
            Err(failure) => {
                self.newton.rollback();
                done.iterations += tolerance.iterations;
                self.spent_iterations += tolerance.iterations;
                Err(failure)
            }
        }
    }

    /// Returns the start state of the increment to `level`, whose load is applied already: extrapolated from the last
    /// two accepted states. A prediction of higher energy (deep contact, infeasible) is replaced by the accepted state.
    pub(crate) fn initial_guess(&self, load: Load, level: f64) -> State {
        let mut plain = self.state.clone();
        if load == Load::Travel {
            plain.travel.iter_mut().for_each(|t| *t = *t + level - self.level);
        }
        let Some((before, at)) = &self.previous else { return plain };
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
