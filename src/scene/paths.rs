//! Paths in a scene, relative to the folder of its file; each must lead to a file.

use super::bonding::BondingRule;
use super::grasps::Grasps;
use super::gripper::Gripper;
use super::object::{Object, ObjectShape};
use super::outline::Outline;
use super::pad::Pads;
use super::schema::ScenePart;
use super::stepper::{SHIPPED_MODELS, StepperChoice};
use crate::robot::mount;
use base::files::regular::special_file_kind;
use std::path::{Path, PathBuf};

/// Resolves paths relative to the folder of the scene file, refuses paths that do not lead to a file, and applies robot
/// descriptions.
pub(super) fn resolve(part: &mut ScenePart, dir: &Path, text: &str) -> std::result::Result<(), (String, String)> {
    let file = |path: &mut PathBuf, field: String| {
        *path = dir.join(&*path);
        match path.metadata() {
            Ok(meta) => match special_file_kind(&meta) {
                Some(kind) => Err((field, format!("{} is {kind}, not a file", path.display()))),
                None => Ok(()),
            },
            Err(_) => Err((
                field,
                format!("no file at {}\npaths are relative to the folder of the scene file", path.display()),
            )),
        }
    };
    let object = |object: &mut Object, field: &str| match &mut object.shape {
        ObjectShape::Mesh(path) => file(path, format!("{field}.shape")),
        _ => Ok(()),
    };
    let grasps = |grasps: &mut Grasps, field: &str| match grasps {
        Grasps::File(grasps) => file(&mut grasps.path, format!("{field}.path")),
        _ => Ok(()),
    };
    let pads = |pads: &mut Pads, field: String| {
        let Pads::File(pad) = pads else { return Ok(()) };
        file(&mut pad.path, format!("{field}.path"))?;
        match &mut pad.bonded {
            BondingRule::NearMesh(mesh) => file(&mut mesh.path, format!("{field}.bonded.path")),
            BondingRule::NodesFile(path) => file(path, format!("{field}.bonded")),
            BondingRule::Plane(_) | BondingRule::Nodes(_) => Ok(()),
        }
    };
    let gripper = |gripper: &mut Gripper, field: &str| {
        pads(&mut gripper.pads, format!("{field}.pads"))?;
        if let Some(own) = gripper.right.as_mut().and_then(|right| right.pads.as_mut()) {
            pads(own, format!("{field}.right.pads"))?;
        }
        let Some(mut robot) = gripper.robot.take() else { return Ok(()) };
        file(&mut robot.path, format!("{field}.robot.path"))?;
        let outline = Outline::of(text);
        let given = |name: &&&str| {
            let field = format!("{field}.{name}");
            outline.find(&field).is_some_and(|entry| outline.path(entry) == field)
        };
        let twice = |names: &[&str]| match names.iter().find(given) {
            Some(name) => {
                let message = format!("the {name} is already defined by the robot; leave one of them out");
                Err((format!("{field}.{name}"), message))
            }
            None => Ok(()),
        };
        twice(&["opening", "stroke", "placement"])?;
        let pads = [robot.pads.0.as_str(), robot.pads.1.as_str()];
        let mounted = mount(&robot.path, &robot.hand, pads, robot.approach.vector());
        if mounted.as_ref().is_ok_and(|mounted| mounted.soft.is_some()) {
            twice(&["pads", "material", "right.pads", "right.material"])?;
        }
        mounted.and_then(|mounted| gripper.apply_robot(mounted)).map_err(|message| (format!("{field}.robot"), message))
    };
    part.object.as_mut().map_or(Ok(()), |o| object(o, "object"))?;
    part.grasps.as_mut().map_or(Ok(()), |g| grasps(g, "grasps"))?;
    part.gripper.as_mut().map_or(Ok(()), |g| gripper(g, "gripper"))?;
    for (i, entry) in part.objects.iter_mut().flatten().enumerate() {
        object(&mut entry.object, &format!("objects[{i}].object"))?;
        entry.grasps.as_mut().map_or(Ok(()), |g| grasps(g, &format!("objects[{i}].grasps")))?;
        entry.gripper.as_mut().map_or(Ok(()), |g| gripper(g, &format!("objects[{i}].gripper")))?;
    }
    if let Some(StepperChoice::Gnn(gnn)) = &mut part.stepper {
        // the engine checks whether the model exists
        if !SHIPPED_MODELS.iter().any(|name| gnn.model.as_os_str() == *name) {
            gnn.model = dir.join(&gnn.model);
        }
    }
    Ok(())
}
