//! Bodies and sites of a robot in MJCF.

use super::{Joint, Link};
use glam::{DQuat, DVec3};
use mjcf_rs::body::{Body, JointType};
use std::path::Path;

/// Reads the bodies of a file with all that it includes; a site is a link that is fixed on its body.
pub(super) fn read(path: &Path) -> Result<Vec<Link>, String> {
    let model = mjcf_rs::Model::from_file(path).map_err(|e| format!("is no readable MJCF: {e}"))?;
    let named = |name: &Option<String>| name.clone().unwrap_or_default();
    let link = |name: String, parent: Option<usize>, pose: &mjcf_rs::Pose, joint: Joint| Link {
        name,
        parent,
        rotation: DQuat::from_array(pose.rotation.to_array()),
        position: DVec3::from_array(pose.translation.to_array()),
        joint,
    };
    let bodies = model.bodies.iter().map(|e| link(named(&e.body.name), e.parent, &e.body.pose, joint(&e.body)));
    let mut links: Vec<Link> = bodies.collect();
    for (body, entry) in model.bodies.iter().enumerate() {
        links.extend(entry.body.sites.iter().map(|s| link(named(&s.name), Some(body), &s.pose, Joint::Fixed)));
    }
    Ok(links)
}

/// Returns the joint of a body.
fn joint(body: &Body) -> Joint {
    match &body.joints[..] {
        [] => Joint::Fixed,
        [joint] if joint.type_ == JointType::Slide => {
            let range = joint.range.unwrap_or_default().map(|way| way - joint.ref_);
            Joint::Slides { axis: DVec3::from_array(joint.axis).normalize_or_zero(), range }
        }
        _ => Joint::Other,
    }
}
