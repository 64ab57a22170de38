//! How well posed a grasp is: how far pads and object move when what nobody knows exactly is a little different.
//!
//! A ball hardly cares; a capsule on its edge turns elsewhere when friction changes by a tenth. Errors of a solver or a network below that
//! spread are not worth anything, and say nothing of who is right.

use super::{Observer, run_grasps};
use crate::error::Result;
use crate::grasp::GraspPose;
use crate::model::Model;
use crate::record::sensitivity::{Change, Moved};
use crate::record::{Frame, Status};
use crate::scene::leaf::{NonNegative, Positive};
use crate::scene::{Loading, Scene};
use crate::stepper::Stepper;
use glam::{DQuat, DVec3};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// All changes, in the order of the report.
const CHANGES: [Change; 4] = [Change::Friction, Change::Turn, Change::Shift, Change::Release];

/// By how much friction changes.
const FRICTION: f64 = 0.1;
/// By how much the hand turns, rad, and moves, m.
const TURN: f64 = 0.5 * std::f64::consts::PI / 180.0;
const SHIFT: f64 = 2e-4;

/// Whether a change means anything for `model`.
fn applies(change: Change, model: &Model) -> bool {
    change != Change::Release || model.lets_go()
}

/// The scene with a change.
fn changed_scene(change: Change, scene: &Scene, model: &Model) -> Scene {
    let mut scene = scene.clone();
    match (change, &mut scene.loading) {
        (Change::Friction, _) => {
            let more = NonNegative::new(scene.gripper.friction.get() + FRICTION);
            scene.gripper.friction = more.unwrap_or(scene.gripper.friction);
        }
        (Change::Release, Loading::Squeeze(squeeze)) => {
            squeeze.release = Positive::new(0.5 * model.release * model.fingers.len() as f64).ok();
        }
        _ => {}
    }
    scene
}

/// The grasp with a change.
fn changed_pose(change: Change, mut pose: GraspPose) -> GraspPose {
    match change {
        Change::Turn => {
            // About the point between the pads, which stays where it is.
            let turn = DQuat::from_axis_angle(DVec3::Y, TURN);
            let grip = DVec3::Z * crate::scene::defaults::PLACEMENT_Z.get();
            pose.position += pose.rotation * (grip - turn * grip);
            pose.rotation *= turn;
        }
        Change::Shift => pose.position += pose.rotation * (DVec3::Z * SHIFT),
        _ => {}
    }
    pose
}

/// Keeps the last frame of every grasp.
#[derive(Default)]
struct Last(Mutex<BTreeMap<usize, Frame>>);

impl Observer for Last {
    fn frame(&self, index: usize, frame: &Frame) -> Result<()> {
        if let Ok(mut frames) = self.0.lock() {
            frames.insert(index, frame.clone());
        }
        Ok(())
    }
}

/// How the grasps ended, and their last frames.
type Ends = BTreeMap<usize, (Status, Option<Frame>)>;

fn ends(model: &Arc<Model>, stepper: &dyn Stepper, grasps: &[(usize, GraspPose)], threads: usize) -> Result<Ends> {
    let last = Last::default();
    let outcomes = run_grasps(model, stepper, grasps, threads, &last)?;
    let mut frames = last.0.into_inner().unwrap_or_default();
    let of = |((index, _), outcome): (&(usize, GraspPose), super::Outcome)| {
        (*index, (outcome.summary.status, frames.remove(index)))
    };
    Ok(grasps.iter().zip(outcomes).map(of).collect())
}

/// Runs `grasps` of `scene` as they are and with every change; what each does, per grasp. Five times the work of a run.
///
/// # Errors
/// Those of building a model and of running grasps.
pub fn sensitivity(
    scene: &Scene,
    model: &Arc<Model>,
    stepper: &dyn Stepper,
    grasps: &[(usize, GraspPose)],
    threads: usize,
) -> Result<Vec<Vec<Moved>>> {
    let base = ends(model, stepper, grasps, threads)?;
    let mut answers = vec![Vec::new(); grasps.len()];
    for change in CHANGES.into_iter().filter(|change| applies(*change, model)) {
        let changed = match change {
            Change::Turn | Change::Shift => model.clone(),
            Change::Friction | Change::Release => Model::build(&changed_scene(change, scene, model))?,
        };
        let posed: Vec<_> = grasps.iter().map(|(index, pose)| (*index, changed_pose(change, *pose))).collect();
        let mut other = ends(&changed, stepper, &posed, threads)?;
        for (answer, ((index, pose), (_, posed))) in answers.iter_mut().zip(grasps.iter().zip(&posed)) {
            let (Some((was, before)), Some((status, after))) = (base.get(index), other.remove(index)) else { continue };
            let reached = (*was, status) == (Status::Reached, Status::Reached);
            let pair = before.as_ref().zip(after.as_ref()).filter(|_| reached);
            answer.push(Moved {
                change,
                status,
                displacement: pair.map(|(a, b)| apart(model, a, b)),
                object_m: pair.map(|(a, b)| {
                    let ([p, turn], [q, other]) = (motion(a, pose), motion(b, posed));
                    p.distance(q) + model.object.bounding_radius * turn.distance(other)
                }),
            });
        }
    }
    Ok(answers)
}

/// Motion of the object since first contact: translation, m, and rotation, rad, as a vector.
fn motion(frame: &Frame, grasp: &GraspPose) -> [DVec3; 2] {
    let start = grasp.object_in_hand();
    let turn = frame.object_rotation * start.rotation.inverse();
    [frame.object_position - start.position, turn.to_scaled_axis()]
}

/// Distance of the displacements of two frames over the norm of the first, L2 over the volume of the gel.
fn apart(model: &Model, a: &Frame, b: &Frame) -> f64 {
    let (mut apart, mut whole) = (0.0, 0.0);
    for (finger, (a, b)) in model.fingers.iter().zip(a.pads.iter().zip(&b.pads)) {
        let volumes = finger.body.nodal_volume();
        for (volume, (a, b)) in volumes.iter().zip(a.displacement.iter().zip(&b.displacement)) {
            apart += volume * a.distance_squared(*b);
            whole += volume * a.length_squared();
        }
    }
    if whole > 0.0 { (apart / whole).sqrt() } else { 0.0 }
}
