//! Resolves the grasps of a scene to poses.

use super::antipodal::{self, Sampled};
use super::h5::{object_scale, read_grasp_file};
use crate::gripper::Hand;
use crate::part::{object, pad};
use base::error::{Error, Result};
use base::number::{format_count, format_number};
use geometry::Aabb;
use geometry::Pose;
use glam::{DQuat, DVec3};
use scene::vector::Vec3;
use scene::{Antipodal, GraspCount, GraspFile, Grasps, ListedPose, Object, Scene, Select};

/// Grasps of a scene, with notices about how they were obtained.
#[derive(Debug, Clone, PartialEq)]
pub struct ResolvedGrasps {
    /// Grasps, in order.
    pub poses: Vec<Pose>,
    /// Notices, one sentence each.
    pub notices: Vec<String>,
}

/// Returns all grasps of the scene, in order; reads the grasp file or samples grasps if necessary.
///
/// # Errors
/// Fails as [`resolve_grasps`] does.
pub fn grasp_poses(scene: &Scene) -> Result<Vec<Pose>> {
    resolve_grasps(scene).map(|resolved| resolved.poses)
}

/// Returns all grasps of the scene, in order, with notices.
///
/// # Errors
/// Fails if the grasp file cannot be read or selects grasps that it does not have, and as [`sample_grasps`] does.
pub fn resolve_grasps(scene: &Scene) -> Result<ResolvedGrasps> {
    let mut notices = Vec::new();
    let between = scene.gripper.placement.center();
    let poses = match &scene.grasps {
        Grasps::Identity => vec![Pose { position: -between, rotation: DQuat::IDENTITY }],
        Grasps::List(poses) => {
            let pose = |p: &ListedPose| {
                let rotation = p.rotation.quat();
                let centred = || p.centre.map_or(DVec3::ZERO, Vec3::dvec3) - rotation * between;
                Pose { position: p.position.map_or_else(centred, Vec3::dvec3), rotation }
            };
            poses.iter().map(pose).collect()
        }
        Grasps::File(file) => from_file(file).map_err(|e| e.with_field("grasps"))?,
        Grasps::Antipodal(wanted) => {
            let sampled = sample_grasps(scene, wanted).map_err(|e| e.with_field("grasps"))?;
            notices.push(sampled.report());
            sampled.poses
        }
    };
    Ok(ResolvedGrasps { poses, notices })
}

/// Returns the object of the scene with its scale. If the scene gives no scale, the `object/scale` of the grasp file is
/// used, with a notice; if the two differ, the scale of the scene is used, with a notice.
///
/// # Errors
/// Fails if the grasp file cannot be read.
pub fn resolve_object(scene: &Scene, notices: &mut Vec<String>) -> Result<Object> {
    let mut object = scene.object.clone();
    let Grasps::File(file) = &scene.grasps else { return Ok(object) };
    let Some(scale) = object_scale(&file.path).map_err(|e| e.with_field("grasps"))? else { return Ok(object) };
    let (path, stated) = (file.path.display(), format_number(scale.get()));
    match object.scale {
        Some(own) if own == scale => {}
        Some(own) => notices.push(format!(
            "{path}: the grasps belong to the object at `object/scale` {stated}, but the scene sets `scale: {}`",
            format_number(own.get())
        )),
        None => {
            notices.push(format!(
                "{path}: the object is scaled by the file's `object/scale`, {stated}; `scale` of the object in the \
                 scene overrides it"
            ));
            object.scale = Some(scale);
        }
    }
    Ok(object)
}

/// Keeps at most the first `most` grasps of a scene.
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

/// Reads the selected grasps of a file; all if there is no selection.
fn from_file(file: &GraspFile) -> Result<Vec<Pose>> {
    let all = read_grasp_file(file)?;
    if all.is_empty() {
        return Err(Error::file(&file.path, "contains no grasp"));
    }
    let Some(select) = &file.select else { return Ok(all) };
    let pick = |row: usize| {
        all.get(row).copied().ok_or_else(|| {
            let message =
                format!("has no grasp {row}; it has {}, 0 to {}", format_count(all.len(), "grasp"), all.len() - 1);
            Error::file(&file.path, message)
        })
    };
    select.rows().into_iter().map(pick).collect()
}

/// Samples grasps of the scene's object.
///
/// # Errors
/// Fails if object or pad cannot be built, or if too few grasps are found.
pub fn sample_grasps(scene: &Scene, wanted: &Antipodal) -> Result<Sampled> {
    // These notices are discarded: building the model reports the repairs.
    let mut notices = Vec::new();
    let object = object::build(&scene.object, &mut notices).map_err(|e| e.with_field("object.shape"))?;
    let gripper = &scene.gripper;
    let (mut nodes, mut friction) = (Vec::new(), f64::INFINITY);
    for side in 0..if gripper.has_equal_fingers() { 1 } else { 2 } {
        let own = gripper.with_equal_fingers(side);
        let (pad, _) = pad::build(&own.pads, &mut notices).map_err(|e| e.with_field("gripper.pads"))?;
        nodes.extend(pad.mesh.nodes);
        friction = friction.min(own.friction.get());
    }
    let hand = Hand::new(Aabb::from_points(nodes), gripper);
    antipodal::sample(wanted, &object, &hand, friction, gripper.stroke.get())
}
