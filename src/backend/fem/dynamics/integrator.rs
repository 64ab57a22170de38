//! Implicit time integration of a dynamic grasp (backward Euler): each step extrapolates the motion, solves for the end
//! of the step by Newton's method and accepts it; a step that fails is rolled back and repeated with a smaller size.

use super::{initial_guess, terms};
use base::error;
use base::saved_state::{StateReader, StateWriter};
use base::scales::LARGEST_PREDICTED_MOTION;
use bevy_ecs::prelude::*;
use geometry::Pose;
use glam::DQuat;
use mech::newton::effort::iteration_limit;
use mech::newton::{Failure, NewtonTolerance};
use mech::path::step_size::StepSize;
use mech::path::{AdvanceCost, Path};
use mech::potential::state::State;
use mech::potential::time_step::TimeStep;
use model::{Dynamics, Model};
use scene::motion::HandState;

/// Time integrator of a dynamic grasp: backward Euler with an adaptive step size. It stores the time, the state of the
/// hand and the previous state for the extrapolation; velocities and friction anchors are stored in the terms of the
/// potential.
#[derive(Resource, Debug)]
pub struct Integrator {
    /// Time reached, s.
    pub time: f64,
    /// Prescribed state of the hand at `time`: its pose in the world, and the sum of the closing forces.
    pub hand: HandState,
    pose: Pose,
    /// State one step before the accepted one, and the size of that step, s.
    before: Option<(State, f64)>,
    /// Size of the next step, s, at most the scene's time step.
    size: StepSize,
}

/// Shortest step, over the time step; if it fails, the grasp ends.
const SHORTEST_TIME_STEP: f64 = 1.0 / 64.0;
/// Residual of a time step over that of a quasi-static increment: momentum errors accumulate over the steps.
const TIME_STEP_TOLERANCE: f64 = 1e-2;
/// Largest motion of any point in an iteration, in a scene with pads, over that of a quasi-static increment. Without
/// pads the motion is unlimited: there is nothing to jump over.
const MOTION_FACTOR: f64 = 2.0;

impl Integrator {
    /// Creates the integrator at time zero for the motions of `dynamics`. `pose` is the pose of the hand in the object
    /// frame at the start.
    pub fn new(dynamics: &Dynamics, pose: Pose) -> Self {
        Self { time: 0.0, hand: dynamics.hand(&pose, 0.0), pose, before: None, size: StepSize::UNKNOWN }
    }

    /// Advances the state of `path` to the time `end` (s), in one or more time steps of at most the time step of the
    /// scene. `settings` are the finite element settings of the scene. Returns the numbers of iterations and steps, and
    /// the residual of the last step, N.
    ///
    /// # Errors
    /// Fails if a step of the smallest size (1/64 of a time step) does not converge, or if the limit of iterations or
    /// wall time is reached. Returns the time at the end of that step, s, and the cause. The state is then the last
    /// accepted one.
    pub fn advance(
        &mut self,
        path: &mut Path,
        model: &Model,
        dynamics: &Dynamics,
        settings: &scene::Fem,
        end: f64,
    ) -> Result<AdvanceCost, (f64, Failure)> {
        if self.before.is_none() {
            self.begin(path, model, dynamics, settings);
        }
        let (from, whole) = (self.time, end - self.time);
        let steps = (whole / dynamics.time_step * (1.0 - 1e-9)).ceil().max(1.0) as u64;
        let mut done = AdvanceCost::default();
        for k in 1..=steps {
            // The last step ends at `end` exactly.
            let to = if k == steps { end } else { from + whole * k as f64 / steps as f64 };
            let shortest = (to - self.time) * SHORTEST_TIME_STEP;
            while self.time < to {
                let rest = to - self.time;
                let size = self.size.next(rest);
                let end = if size >= rest { to } else { self.time + size };
                let before = done.iterations;
                match self.step(path, model, dynamics, end, &mut done) {
                    Ok(()) => self.size.accept(size, done.iterations - before, 0.0, 0.0),
                    Err(failure) if size <= shortest || failure.is_out_of_effort() => return Err((end, failure)),
                    Err(_) => self.size.reject(size, None),
                }
            }
        }
        Ok(done)
    }

    /// Adds the dynamic terms to the solver, and sets its tolerances.
    fn begin(&mut self, path: &mut Path, model: &Model, dynamics: &Dynamics, settings: &scene::Fem) {
        if !model.free {
            hold_in_world(&mut path.state, &self.hand.pose);
        }
        terms::add(&mut path.newton, model, dynamics, &path.state, self.hand.pose);
        let end = model.levels.last().copied().unwrap_or(0.0);
        let steps = (end / dynamics.time_step).ceil() as usize;
        path.newton.effort.iterations = iteration_limit(settings.max_iterations.get() as u32, steps);
        let relative = TIME_STEP_TOLERANCE * settings.tolerance.force.get();
        let force = dynamics.rated_force + model.mass * dynamics.gravity.length().max(1.0);
        let usual = NewtonTolerance::new(model.offset);
        path.tolerance = NewtonTolerance {
            relative,
            force: 1e-2 * relative * force,
            length: settings.tolerance.displacement.map_or(usual.length, |length| length.get()),
            iterations: settings.max_iterations.get() as u32,
            max_motion: if model.fingers.is_empty() { f64::INFINITY } else { MOTION_FACTOR * usual.max_motion },
            ..usual
        };
        // The object was already moving before the start.
        let mut before = path.state.clone();
        if model.free {
            let (h, back) = (dynamics.time_step, self.hand.pose.rotation.conjugate());
            let turn = DQuat::from_scaled_axis(back * dynamics.spin * -h);
            let arm = before.rotation * model.object.mass.center;
            before.position += arm - turn * arm - back * dynamics.velocity * h;
            before.rotation = (turn * before.rotation).normalize();
        }
        self.before = Some((before, dynamics.time_step));
    }

    /// Writes everything that the next step depends on, except the path.
    pub(crate) fn save_state(&self, history: &mut StateWriter) {
        history.write(&(self.time, self.size, &self.before));
    }

    /// Reads what [`Integrator::save_state`] wrote; adds the dynamic terms to `path` if motion had begun.
    ///
    /// # Errors
    /// Fails if the history does not match.
    pub(crate) fn restore_state(
        &mut self,
        path: &mut Path,
        model: &Model,
        dynamics: &Dynamics,
        settings: &scene::Fem,
        history: &mut StateReader,
    ) -> error::Result<()> {
        let before: Option<(State, f64)>;
        (self.time, self.size, before) = history.read()?;
        if before.is_some() {
            self.begin(path, model, dynamics, settings);
        }
        (self.before, self.hand) = (before, dynamics.hand(&self.pose, self.time));
        Ok(())
    }

    fn step(
        &mut self,
        path: &mut Path,
        model: &Model,
        dynamics: &Dynamics,
        end: f64,
        done: &mut AdvanceCost,
    ) -> Result<(), Failure> {
        let size = end - self.time;
        let hand = dynamics.hand(&self.pose, end);
        let step = TimeStep { size, hand: hand.pose };
        let newton = &mut path.newton;
        newton.step = Some(step);
        // The choice of the initial guess below compares energies, which depend on the start of the step.
        newton.begin_increment(&path.state);
        newton.force.fill(hand.force / model.fingers.len().max(1) as f64);
        let mut here = path.state.clone();
        let mut predicted = match &self.before {
            Some((before, earlier)) => here.extrapolated(before, size / earlier),
            None => here.clone(),
        };
        if !model.free {
            hold_in_world(&mut here, &hand.pose);
            hold_in_world(&mut predicted, &hand.pose);
        }
        let start =
            initial_guess::initial_guess(newton, &here, predicted, LARGEST_PREDICTED_MOTION * path.tolerance.offset);
        match newton.solve(&path.state, start, &path.tolerance) {
            Ok((state, converged)) => {
                newton.commit(&state);
                done.iterations += converged.iterations;
                done.increments += 1;
                done.residual = converged.residual;
                self.before = Some((std::mem::replace(&mut path.state, state), size));
                (self.time, self.hand) = (end, hand);
                Ok(())
            }
            Err(failure) => {
                newton.rollback();
                done.iterations += path.tolerance.iterations;
                Err(failure)
            }
        }
    }
}

/// Keeps a fixed object at its pose in the world while the hand moves.
fn hold_in_world(state: &mut State, hand: &Pose) {
    state.rotation = hand.rotation.conjugate();
    state.position = hand.inverse_transform(glam::DVec3::ZERO);
}
