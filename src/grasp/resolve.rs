//! The grasps of a scene as poses.

use super::h5::read_grasps_h5;
use super::pose::GraspPose;
use crate::error::{Error, Result};
use crate::scene::{Grasps, Scene};
use glam::{DQuat, DVec3};

/// All grasps of the scene, in order; reads the grasp file if the scene names one.
pub fn poses_of(scene: &Scene) -> Result<Vec<GraspPose>> {
    match &scene.grasps {
        Grasps::Identity => {
            let placement = scene.gripper.placement;
            let position = -DVec3::new(0.0, placement.y.get(), placement.z.get());
            Ok(vec![GraspPose { position, rotation: DQuat::IDENTITY }])
        }
        Grasps::List(poses) => {
            Ok(poses.iter().map(|p| GraspPose { position: p.position.dvec3(), rotation: p.rotation.quat() }).collect())
        }
        Grasps::File(file) => {
            let all = read_grasps_h5(&file.path)?;
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
        Grasps::Antipodal(_) => Err(Error::Scene(
            "error: grasps: Antipodal grasps are not available in this build; use List([...]), File(\"x_grasps.h5\") or Identity"
                .into(),
        )),
    }
}
