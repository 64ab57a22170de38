//! Frame of a step, read from the columns, and the phase of the next step.

use crate::components::*;
use crate::schedule::{
    BalanceReport, ForceCommand, NextPhase, Phase, RecordedFrame, SharedModel, StepLoad, StepReport,
};
use bevy_ecs::prelude::*;
use glam::DVec3;
use record::{DynamicState, Frame, PadFrame};

/// Node columns of a frame; optional ones are None if the scene does not need them.
type Nodes<'a> = (
    &'a FingerIndex,
    &'a RestPosition,
    &'a Position,
    Option<&'a NodalStress>,
    Option<&'a ContactForce>,
    Option<&'a NodeGap>,
    Option<&'a NodeSlip>,
);
/// Finger columns of a frame; the contact area exists only if the scene observes it.
type Fingers<'a> = (
    &'a FingerIndex,
    &'a ClosingDirection,
    &'a FirstContact,
    &'a FingerTravel,
    &'a FingerWrench,
    Option<&'a ContactArea>,
);

/// Columns of the object; all except the pose exist only in a dynamic scene.
type Object<'a> = (&'a ObjectPose, Option<(&'a ObjectVelocity, &'a ObjectMomentum)>, Option<&'a GroundWrench>);

/// Builds the frame of this step.
#[allow(clippy::too_many_arguments)]
pub fn record_frame(
    phase: Res<Phase>,
    shared: Res<SharedModel>,
    load: Res<StepLoad>,
    report: Res<StepReport>,
    balance: Res<BalanceReport>,
    mut recorded: ResMut<RecordedFrame>,
    nodes: Query<Nodes>,
    tets: Query<(&FingerIndex, &TetStress)>,
    fingers: Query<Fingers>,
    object: Single<Object>,
    hand: Query<&HandPose>,
) {
    let Phase::Ramp { frame: index } = *phase else { return };
    let mut pads = vec![PadFrame::default(); shared.0.fingers.len()];
    let mut travel = vec![0.0; pads.len()];
    let mut carried = vec![DVec3::ZERO; pads.len()];
    for (finger, closing, first, now, wrench, area) in &fingers {
        let f = finger.0 as usize;
        travel[f] = now.0 - first.0;
        carried[f] = closing.0 * now.0;
        pads[f].wrench = wrench.0;
        pads[f].contact_area = area.map_or(0.0, |area| area.0);
    }
    for (finger, rest, position, stress, force, gap, slip) in nodes.contiguous_iter().expect(TABLES) {
        for (f, rows) in rows_by_pad(finger) {
            let (pad, x) = (&mut pads[f], &position[rows.clone()]);
            pad.position = x.iter().map(|x| x.0 + carried[f]).collect();
            pad.displacement = x.iter().zip(&rest[rows.clone()]).map(|(x, rest)| x.0 - rest.0).collect();
            if let Some(stress) = stress {
                pad.von_mises_node = stress[rows.clone()].iter().map(|s| s.0).collect();
            }
            if let Some(force) = force {
                pad.contact_force = force[rows.clone()].iter().map(|f| f.0).collect();
            }
            if let Some(gap) = gap {
                pad.gap = gap[rows.clone()].iter().map(|g| g.0).collect();
            }
            if let Some(slip) = slip {
                pad.slip = slip[rows].iter().map(|s| s.0).collect();
            }
        }
    }
    for (finger, stress) in tets.contiguous_iter().expect(TABLES) {
        rows_by_pad(finger)
            .for_each(|(f, rows)| pads[f].von_mises_element = stress[rows].iter().map(|s| s.0).collect());
    }
    let (object, motion, ground) = *object;
    let moving = hand.iter().next().map(|hand| {
        let (velocity, momentum) = motion.map_or_else(Default::default, |(v, m)| (*v, *m));
        DynamicState {
            hand_position: hand.0.position,
            hand_rotation: hand.0.rotation,
            velocity: velocity.linear,
            spin: velocity.angular,
            momentum: momentum.linear,
            angular_momentum: momentum.angular,
            ground_force: ground.map_or(DVec3::ZERO, |g| hand.0.rotation * g.0.force),
        }
    });
    recorded.0 = Some(Frame {
        index,
        applied_force: balance.applied,
        time: if moving.is_some() { load.level } else { 0.0 },
        travel,
        object_position: object.0.position,
        object_rotation: object.0.rotation,
        object_load: balance.load,
        pads,
        moving,
        energy: report.energy,
        newton_iterations: report.iterations,
        object_fixed: balance.object_fixed,
        min_det_f: report.min_det_f,
        min_gap: report.min_gap,
        force_balance: balance.force,
        torque_balance: balance.torque,
        residual: report.residual,
        error: report.error,
        tactile: Vec::new(),
    });
}

/// Advances the procedure: to the phase that a system requested, otherwise to the next frame.
pub fn advance_phase(
    mut phase: ResMut<Phase>,
    mut next: ResMut<NextPhase>,
    mut report: ResMut<StepReport>,
    shared: Res<SharedModel>,
    command: Option<Res<ForceCommand>>,
) {
    let asked = next.take();
    if let (Phase::Ramp { frame }, None) = (&*phase, &asked)
        && report.reached
    {
        let frame = frame + 1;
        *phase = if command.is_some() || frame < shared.0.levels.len() { Phase::Ramp { frame } } else { Phase::Done };
    } else if let Some(asked) = asked {
        *phase = asked;
    }
    // The run conditions of the next step must not use the success of this one.
    report.reached = false;
}
