//! Commands of the gripper: the pose of the object at the start, and the load of the next frame.

use crate::components::{FingerForce, FingerTravel, ObjectPose, ObjectWeight};
use crate::schedule::{ForceCommand, GraspPose, NextPhase, Phase, SharedModel, StepLoad, StepReport};
use bevy_ecs::prelude::*;
use glam::DVec3;
use model::Model;

/// Places the object at its grasp pose in the open hand.
pub fn place_object(
    phase: Res<Phase>,
    grasp: Res<GraspPose>,
    mut next: ResMut<NextPhase>,
    mut pose: Single<&mut ObjectPose>,
    mut travel: Query<&mut FingerTravel>,
) {
    if *phase != Phase::Place {
        return;
    }
    let start = grasp.0.inverse();
    pose.0 = start;
    travel.iter_mut().for_each(|mut t| t.0 = 0.0);
    next.request(Phase::Close);
}

/// Rejects a weight that the squeeze cannot carry along the closing direction: geared fingers share their force, so the
/// one under the object carries at most their sum.
pub fn refuse_weight(
    phase: Res<Phase>,
    shared: Res<SharedModel>,
    mut next: ResMut<NextPhase>,
    weight: Single<&ObjectWeight>,
) {
    if *phase == Phase::Place
        && let Some(reason) = excessive_weight(&shared.0, weight.0)
    {
        next.request(Phase::Infeasible { reason });
    }
}

/// Returns why a squeeze cannot carry this weight, N, hand frame, along the closing direction; None if it can.
pub fn excessive_weight(model: &Model, weight: DVec3) -> Option<String> {
    let squeezed = model.force_driven && model.dynamics.is_none();
    let finger = model.fingers.first().filter(|_| squeezed)?;
    let along = weight.dot(finger.placement.closing).abs();
    let total = model.levels.last().copied().unwrap_or(0.0) * model.fingers.len() as f64;
    (along > total).then(|| {
        format!(
            "gravity acts on the object with {along:.3} N along the closing direction; fingers that squeeze it with \
             {total:.3} N in total cannot support it: increase the force, or rotate the hand or gravity"
        )
    })
}

/// Sets the load of the frame that this step computes.
pub fn set_load(
    phase: Res<Phase>,
    shared: Res<SharedModel>,
    grasp: Res<GraspPose>,
    command: Option<Res<ForceCommand>>,
    mut load: ResMut<StepLoad>,
    mut report: ResMut<StepReport>,
    mut forces: Query<&mut FingerForce>,
) {
    let Phase::Ramp { frame } = *phase else { return };
    let model = &shared.0;
    let level = command.as_ref().map_or_else(|| model.levels[frame], |command| command.force);
    *load = StepLoad { level, push: if command.is_some() { 0.0 } else { model.push_fraction(frame) } };
    *report = StepReport::default();
    match &model.dynamics {
        Some(dynamics) => {
            let each = dynamics.hand(&grasp.0, level).force / model.fingers.len().max(1) as f64;
            forces.iter_mut().for_each(|mut f| f.0 = each);
        }
        None if model.force_driven => forces.iter_mut().for_each(|mut f| f.0 = level),
        None => {}
    }
}
