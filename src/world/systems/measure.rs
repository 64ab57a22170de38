//! Balance of the forces of a frame, computed from the wrenches alone, for any stepper.

use crate::components::*;
use crate::schedule::{BalanceReport, GraspPose, NextPhase, Phase, SharedModel, StepLoad, StepReport};
use bevy_ecs::prelude::*;
use geometry::Wrench;
use glam::DVec3;

/// Loads on the object in addition to those of the pads.
type Loads<'a> = (&'a ObjectPose, Option<&'a ObjectWeight>, Option<&'a GroundWrench>, Option<&'a InertialWrench>);

/// Measures the force and torque balance. For a free object, contact forces, weight, support and inertia must cancel.
/// For a fixed one, each finger's contact must carry the force that closes it; for a free one that is still held, this
/// applies to the sum over the fingers.
pub fn measure_balance(
    shared: Res<SharedModel>,
    grasp: Res<GraspPose>,
    load: Res<StepLoad>,
    mut balance: ResMut<BalanceReport>,
    fingers: Query<(&FingerIndex, &ClosingDirection, &FingerTravel, &FingerForce, &FingerWrench)>,
    object: Single<Loads>,
) {
    let model = &shared.0;
    let (pose, weight, ground, inertia) = *object;
    let weight = weight.map_or(DVec3::ZERO, |w| w.0);
    let center = pose.0.position + pose.0.rotation * model.object.mass.center;
    let (mut applied, mut worst, mut pushed, mut carried) = (0.0, 0.0_f64, 0.0, 0.0);
    let (mut force, mut torque) = (weight, DVec3::ZERO);
    let ground = ground.copied().unwrap_or_default();
    let inertia = inertia.copied().unwrap_or_default();
    if let Some(push) = &model.push {
        let turn = pose.0.rotation * grasp.0.inverse().rotation.inverse();
        force += push.force * load.push;
        torque += push.torque_after(turn) * load.push;
    }
    balance.load = Wrench { force, torque };
    force += ground.0.force + inertia.0.force;
    torque += ground.0.torque + inertia.0.torque;
    for (index, closing, travel, given, wrench) in &fingers {
        let normal = -wrench.0.force.dot(closing.0);
        applied += given.0;
        carried += normal;
        pushed += wrench.0.force.length();
        worst = worst.max((given.0 - normal).abs());
        force -= wrench.0.force;
        let origin = model.fingers[index.0 as usize].placement.origin + closing.0 * travel.0;
        torque -= wrench.0.torque + (origin - center).cross(wrench.0.force);
    }
    let unbalanced = match (model.free, &model.dynamics) {
        (true, _) if balance.object_fixed => (applied - carried).abs(),
        (true, _) => force.length(),
        (false, None) => worst,
        // The force of a finger differs from that of its contact by the inertia of pad and drive.
        (false, Some(_)) => 0.0,
    };
    // Without any contact, as in free flight, there is no force to compare with.
    let alone = |value: f64, scale: f64| value == 0.0 || scale == 0.0 && model.dynamics.is_some();
    let relative = |value: f64, scale: f64| if alone(value, scale) { 0.0 } else { value / scale };
    let torque = if model.free && !balance.object_fixed { torque.length() } else { 0.0 };
    // In a quasi-static scene the fingers' force is the scale, however heavy the object.
    let scale = match model.dynamics {
        None => applied,
        Some(_) => applied + weight.length() + ground.0.force.length() + pushed,
    };
    *balance = BalanceReport {
        load: balance.load,
        object_fixed: balance.object_fixed,
        applied,
        force: relative(unbalanced, scale),
        torque: relative(torque, scale * model.object.bounding_radius),
    };
}

/// Out-of-balance force, over the applied force, above which a state is no equilibrium, for any solver tolerance.
const NO_EQUILIBRIUM: f64 = 0.1;

/// Ends the grasp with a fault, without recording the frame, if the forces of the state do not balance, although the
/// stepper reported it as reached.
pub fn refuse_imbalance(
    balance: Res<BalanceReport>,
    load: Res<StepLoad>,
    mut report: ResMut<StepReport>,
    mut next: ResMut<NextPhase>,
) {
    if balance.force <= NO_EQUILIBRIUM {
        return;
    }
    report.reached = false;
    let (level, off) = (load.level, 100.0 * balance.force);
    let reason =
        format!("at load {level:.4e}: the out-of-balance force is {off:.0} % of the applied force: no equilibrium");
    next.request(Phase::Fault { reason });
}

/// Measures the signed distance of every node to the object.
pub fn measure_gap(
    shared: Res<SharedModel>,
    fingers: Query<(&FingerIndex, &ClosingDirection, &FingerTravel)>,
    object: Single<&ObjectPose>,
    mut nodes: Query<(&FingerIndex, &Position, &mut NodeGap)>,
) {
    let mut carried = vec![DVec3::ZERO; shared.0.fingers.len()];
    for (index, closing, travel) in &fingers {
        carried[index.0 as usize] = closing.0 * travel.0;
    }
    let (inverse, distance) = (object.0.rotation.inverse(), &shared.0.object.distance);
    for (finger, position, mut gap) in nodes.contiguous_iter_mut().expect(TABLES) {
        let gap = gap.bypass_change_detection();
        for (f, rows) in rows_by_pad(finger) {
            let place = |x: &Position| inverse * (x.0 + carried[f] - object.0.position);
            let pairs = gap[rows.clone()].iter_mut().zip(&position[rows]);
            pairs.for_each(|(gap, x)| gap.0 = distance.distance(place(x)));
        }
    }
}
