//! Links of a robot in URDF, and their shapes.

use super::{Joint, Link};
use glam::{DQuat, DVec3, EulerRot};
use std::path::Path;
use urdf_rs::{Collision, JointType};

/// Reads the links of a file, and of each the shapes that it collides with.
pub(super) fn read(path: &Path) -> Result<(Vec<Link>, Vec<Vec<Collision>>), String> {
    let robot = urdf_rs::read_file(path).map_err(|e| format!("is no readable URDF: {e}"))?;
    let root = |link: &urdf_rs::Link| Link {
        name: link.name.clone(),
        parent: None,
        rotation: DQuat::IDENTITY,
        position: DVec3::ZERO,
        joint: Joint::Fixed,
    };
    let mut links: Vec<Link> = robot.links.iter().map(root).collect();
    for joint in &robot.joints {
        let find = |name: &str| {
            let missing = || format!("joint {:?} names the link {name:?}, which is not there", joint.name);
            links.iter().position(|link| link.name == name).ok_or_else(missing)
        };
        let (parent, child) = (find(&joint.parent.link)?, find(&joint.child.link)?);
        let [roll, pitch, yaw] = *joint.origin.rpy;
        let axis = DVec3::from_array(*joint.axis.xyz).normalize_or_zero();
        let link = &mut links[child];
        link.parent = Some(parent);
        link.rotation = DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll);
        link.position = DVec3::from_array(*joint.origin.xyz);
        link.joint = match joint.joint_type {
            JointType::Fixed => Joint::Fixed,
            JointType::Prismatic => Joint::Slides { axis, range: [joint.limit.lower, joint.limit.upper] },
            _ => Joint::Other,
        };
    }
    Ok((links, robot.links.into_iter().map(|link| link.collision).collect()))
}
