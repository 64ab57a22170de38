//! Links of a robot in URDF, and their shapes.

use super::{Joint, Link};
use glam::{DQuat, DVec3, EulerRot};
use roxmltree::Document;
use std::path::Path;
use urdf_rs::{Collision, JointType};

/// Reads the links of a file, and of each the shapes that it collides with.
pub(super) fn read(path: &Path) -> Result<(Vec<Link>, Vec<Vec<Collision>>), String> {
    let unreadable = |e: urdf_rs::UrdfError| match misspelt(path) {
        Some(culprit) => format!("is no readable URDF: {culprit}"),
        None => format!("is no readable URDF: {e}"),
    };
    let robot = urdf_rs::read_file(path).map_err(unreadable)?;
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

/// Returns the first attribute of a file that begins like a number and is none, with its line: `urdf-rs` says neither.
fn misspelt(path: &Path) -> Option<String> {
    let text = std::fs::read_to_string(path).ok()?;
    let document = Document::parse(&text).ok()?;
    let attributes = document.descendants().flat_map(|node| node.attributes());
    let mut numbers = attributes.filter(|a| !["name", "link", "joint", "filename"].contains(&a.name()));
    let wrong = |value: &str| {
        let begins = value.trim_start().starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        begins && value.split_whitespace().any(|word| word.parse::<f64>().is_err())
    };
    let found = numbers.find(|a| wrong(a.value()))?;
    let line = document.text_pos_at(found.range().start).row;
    Some(format!("line {line}: {}={:?} is no number", found.name(), found.value()))
}
