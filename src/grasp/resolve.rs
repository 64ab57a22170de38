//! Grasps of a scene as poses.

use super::antipodal::{self, Sampled};
use super::h5::read_grasp_file;
use crate::error::{Error, Result};
use crate::geometry::Aabb;
use crate::gripper::Hand;
use crate::gripper::pose::GraspPose;
use crate::part::{object, pad};
use crate::scene::{Antipodal, GraspCount, GraspFile, Grasps, Scene, Select};
use glam::{DQuat, DVec3};

/// Grasps of a scene, and notices about how they were found.
#[derive(Debug, Clone, PartialEq)]
pub struct Resolved {
    /// Grasps, in order.
    pub poses: Vec<GraspPose>,
    /// Notices, one sentence each.
    pub notices: Vec<String>,
}

/// Returns all grasps of the scene, in order. Reads the grasp file if the scene names one; samples if the scene asks for that.
///
/// # Errors
/// Fails as [`grasps_of`] does.
pub fn poses_of(scene: &Scene) -> Result<Vec<GraspPose>> {
    grasps_of(scene).map(|resolved| resolved.poses)
}

/// Returns all grasps of the scene, in order, with notices.
///
/// # Errors
/// Fails if the grasp file cannot be read or selects grasps that it does not have, and as [`sample_of`] does.
pub fn grasps_of(scene: &Scene) -> Result<Resolved> {
    let mut notices = Vec::new();
    let poses = match &scene.grasps {
        Grasps::Identity => {
            let placement = scene.gripper.placement;
            let position = -DVec3::new(0.0, placement.y.get(), placement.z.get());
            vec![GraspPose { position, rotation: DQuat::IDENTITY }]
        }
        Grasps::List(poses) => {
            poses.iter().map(|p| GraspPose { position: p.position.dvec3(), rotation: p.rotation.quat() }).collect()
        }
        Grasps::File(file) => from_file(file).map_err(|e| e.about("grasps"))?,
        Grasps::Antipodal(wanted) => {
            let sampled = sample_of(scene, wanted).map_err(|e| e.about("grasps"))?;
            notices.push(sampled.report());
            sampled.poses
        }
    };
    Ok(Resolved { poses, notices })
}

/// Keeps only the first `most` grasps of a scene, or all if there are fewer.
///
/// # Errors
/// Fails if the grasp file cannot be read.
pub fn keep_first(grasps: &mut Grasps, most: GraspCount) -> Result<()> {
    match grasps {
        Grasps::Identity => {}
        Grasps::List(poses) => poses.truncate(most.get()),
        Grasps::File(file) => {
            let all = || Ok((0..read_grasp_file(file)?.len()).collect());
            let mut rows = file.select.as_ref().map_or_else(all, |select| Ok(select.rows()))?;
            rows.truncate(most.get());
            file.select = Some(Select::Rows(rows));
        }
        Grasps::Antipodal(wanted) => wanted.count = wanted.count.min(most),
    }
    Ok(())
}

/// Reads the chosen grasps of a file, all of them unless the scene selects some.
fn from_file(file: &GraspFile) -> Result<Vec<GraspPose>> {
    let all = read_grasp_file(file)?;
    if all.is_empty() {
        return Err(Error::file(&file.path, "holds no grasp"));
    }
    let Some(select) = &file.select else { return Ok(all) };
    let pick = |row: usize| {
        all.get(row).copied().ok_or_else(|| {
            let message = format!("has no grasp {row}; its {} grasps are 0 to {}", all.len(), all.len() - 1);
            Error::file(&file.path, message)
        })
    };
    select.rows().into_iter().map(pick).collect()
}

/// Samples grasps of the scene's object.
///
/// # Errors
/// Fails if object or pad cannot be built, and if too few grasps are found.
pub fn sample_of(scene: &Scene, wanted: &Antipodal) -> Result<Sampled> {
    // Building the model says what was repaired.
    let mut notices = Vec::new();
    let object = object::build(&scene.object, &mut notices).map_err(|e| e.about("object.shape"))?;
    let gripper = &scene.gripper;
    let (mut nodes, mut friction) = (Vec::new(), f64::INFINITY);
    for side in 0..if gripper.alike() { 1 } else { 2 } {
        let own = gripper.like(side);
        let (pad, _) = pad::build(&own.pads, &mut notices).map_err(|e| e.about("gripper.pads"))?;
        nodes.extend(pad.mesh.nodes);
        friction = friction.min(own.friction.get());
    }
    let hand = Hand::new(Aabb::of(nodes), gripper);
    antipodal::sample(wanted, &object, &hand, friction, gripper.stroke.get())
}
