//! Sensitivity of a grasp: difference in the motion of pads and object under small changes of quantities that are not
//! known exactly.
//!
//! A ball hardly changes; a capsule on its edge rotates differently when the friction coefficient changes by 0.1.
//! Errors of a solver or a network below these differences are not significant, and do not show which result is right.

use super::{Observer, Outcome, run_grasps};
use crate::Stepper;
use base::error::Result;
use geometry::Pose;
use glam::{DQuat, DVec3};
use model::Model;
use record::error_norm::{FieldInterpolation, FrameDistance, Points};
use record::sensitivity::{Change, ChangeEffect};
use record::{Frame, PadTopology, Status};
use scene::leaf::{NonNegative, Positive};
use scene::{Loading, Scene};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// All changes, in the order of the report.
pub const CHANGES: [Change; 4] = [Change::Friction, Change::Turn, Change::Shift, Change::Release];

/// Increase of the friction coefficient.
const FRICTION_INCREASE: f64 = 0.1;
/// Rotation of the hand, rad.
const TURN: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// Shift of the hand, m.
const SHIFT: f64 = 2e-4;

/// Returns true if a change affects `model`.
fn applies(change: Change, model: &Model) -> bool {
    change != Change::Release || model.is_released_later()
}

/// Returns the scene with a change.
fn changed_scene(change: Change, scene: &Scene, model: &Model) -> Scene {
    let mut scene = scene.clone();
    match (change, &mut scene.loading) {
        (Change::Friction, _) => {
            let more = NonNegative::new(scene.gripper.friction.get() + FRICTION_INCREASE);
            scene.gripper.friction = more.unwrap_or(scene.gripper.friction);
        }
        (Change::Release, Loading::Squeeze(squeeze)) => {
            squeeze.release = Positive::new(0.5 * model.release * model.fingers.len() as f64).ok();
        }
        _ => {}
    }
    scene
}

/// Returns the grasp with a change; `midpoint` between the pads at zero travel, m, hand frame.
fn changed_pose(change: Change, mut pose: Pose, midpoint: DVec3) -> Pose {
    match change {
        Change::Turn => {
            let turn = DQuat::from_axis_angle(DVec3::Y, TURN);
            pose.position += pose.rotation * (midpoint - turn * midpoint);
            pose.rotation *= turn;
        }
        Change::Shift => pose.position += pose.rotation * (DVec3::Z * SHIFT),
        _ => {}
    }
    pose
}

/// Observer that keeps the last frame of every grasp.
#[derive(Debug, Default)]
pub struct LastFrames(Mutex<BTreeMap<usize, Frame>>);

impl Observer for LastFrames {
    fn frame(&self, index: usize, frame: &Frame) -> Result<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(index, frame.clone());
        Ok(())
    }
}

/// Ends of grasps: status and last frame by number.
#[derive(Debug, Default)]
pub struct FinalStates(BTreeMap<usize, (Status, Option<Frame>)>);

impl FinalStates {
    /// Collects the ends from the outcomes of grasps and the last frames kept while they ran.
    pub fn of(outcomes: &[Outcome], last: LastFrames) -> Self {
        let mut frames = last.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        let end = |o: &Outcome| (o.summary.grasp, (o.summary.status, frames.remove(&o.summary.grasp)));
        Self(outcomes.iter().map(end).collect())
    }
}

/// Runs `grasps` of `scene`, which ended as in `base`, with every change. Returns the effects of each change, per
/// grasp. This takes up to four times the work of a run.
///
/// # Errors
/// Fails if a model cannot be built, and if grasps cannot be run.
pub fn sensitivity(
    scene: &Scene,
    model: &Arc<Model>,
    stepper: &dyn Stepper,
    (grasps, base): (&[(usize, Pose)], &FinalStates),
    threads: usize,
) -> Result<Vec<Vec<ChangeEffect>>> {
    let none = PadTopology::default();
    let pad = model.fingers.first().map_or(&none, |f| &f.topology);
    let points = Points::of(pad);
    let probe = FieldInterpolation::new(&points, pad);
    let midpoint = model.midpoint_between_pads();
    let mut answers = vec![Vec::new(); grasps.len()];
    for change in CHANGES.into_iter().filter(|change| applies(*change, model)) {
        let changed = match change {
            Change::Turn | Change::Shift => model.clone(),
            Change::Friction | Change::Release => Model::build(&changed_scene(change, scene, model))?,
        };
        let posed: Vec<_> =
            grasps.iter().map(|(index, pose)| (*index, changed_pose(change, *pose, midpoint))).collect();
        let last = LastFrames::default();
        let outcomes = run_grasps(&changed, stepper, &posed, threads, &last)?;
        let mut other = FinalStates::of(&outcomes, last).0;
        for (answer, ((index, pose), (_, posed))) in answers.iter_mut().zip(grasps.iter().zip(&posed)) {
            let (Some((was, before)), Some((status, after))) = (base.0.get(index), other.remove(index)) else {
                continue;
            };
            let reached = (*was, status) == (Status::Reached, Status::Reached);
            let pair = before.as_ref().zip(after.as_ref()).filter(|_| reached);
            answer.push(ChangeEffect {
                change,
                status,
                displacement: pair
                    .map(|(a, b)| FrameDistance::of(&points, &probe.fields(b), &probe.fields(a)).displacement),
                object_m: pair.map(|(a, b)| {
                    let ([p, turn], [q, other]) = (motion(a, pose), motion(b, posed));
                    p.distance(q) + model.object.bounding_radius * turn.distance(other)
                }),
            });
        }
    }
    Ok(answers)
}

/// Returns the motion of the object since first contact: translation, m, and rotation, rad, as a vector.
fn motion(frame: &Frame, grasp: &Pose) -> [DVec3; 2] {
    let start = grasp.inverse();
    let turn = frame.object_rotation * start.rotation.inverse();
    [frame.object_position - start.position, turn.to_scaled_axis()]
}
