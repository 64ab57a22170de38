//! Systems of dynamic scenes, in addition to those of the backend.

use super::integrator::Integrator;
use crate::fem::solver::GraspSolver;
use bevy_ecs::prelude::*;
use world::components::*;
use world::schedule::{NextPhase, Phase, SharedModel, StepLoad, StepReport};

/// Integrates up to the time of the frame. On failure the state is the last accepted one and the grasp ends.
pub fn advance_time(
    mut solver: ResMut<GraspSolver>,
    mut integrator: ResMut<Integrator>,
    shared: Res<SharedModel>,
    load: Res<StepLoad>,
    mut report: ResMut<StepReport>,
    mut next: ResMut<NextPhase>,
) {
    let model = &shared.0;
    let Some(dynamics) = &model.dynamics else { return };
    let settings = *solver.settings();
    match integrator.advance(&mut solver.path, model, dynamics, &settings, load.level) {
        Ok(done) => {
            report.reached = true;
            report.iterations = done.iterations;
            report.residual = done.residual;
        }
        Err((time, failure)) => next.request(Phase::Fault {
            reason: format!(
                "at {time:.6} s: {}; the time step of {:e} s was reduced to its lower limit; last accepted \
                 time {:.6} s",
                failure, dynamics.time_step, integrator.time
            ),
        }),
    }
}

/// Measures the hand pose and the motion of the object.
pub fn measure_motion(
    solver: Res<GraspSolver>,
    integrator: Res<Integrator>,
    mut hand: Single<&mut HandPose>,
    mut object: Query<(&mut ObjectVelocity, &mut ObjectMomentum, &mut InertialWrench, Option<&mut ObjectWeight>)>,
) {
    let at = integrator.hand.pose;
    hand.0 = at;
    let Some(inertia) = &solver.path.newton.object.inertia else { return };
    let back = at.rotation.conjugate();
    for (mut velocity, mut momentum, mut wrench, weight) in &mut object {
        *velocity = ObjectVelocity { linear: inertia.motion().velocity, angular: inertia.spin() };
        let (linear, angular) = inertia.momenta();
        *momentum = ObjectMomentum { linear, angular };
        wrench.0 = inertia.inertial_wrench().rotated(|v| back * v);
        if let Some(mut weight) = weight {
            weight.0 = back * inertia.weight();
        }
    }
}

/// Measures the wrench of the ground on the object.
pub fn measure_ground(
    solver: Res<GraspSolver>,
    shared: Res<SharedModel>,
    mut report: ResMut<StepReport>,
    mut object: Query<&mut GroundWrench>,
) {
    let (newton, state) = (&solver.path.newton, &solver.path.state);
    let Some(ground) = &newton.object.ground else { return };
    let center = state.position + state.rotation * shared.0.object.mass.center;
    let on_object = ground.wrench(&state.object_view(&newton.rigid), center);
    object.iter_mut().for_each(|mut wrench| wrench.0 = on_object);
    report.min_gap = report.min_gap.min(ground.min_gap());
}
