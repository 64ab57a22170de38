//! Checks that the grasps of a file match the object.

use crate::gripper::Hand;
use geometry::Aabb;
use geometry::Pose;
use geometry::shape::Shape;
use glam::DVec3;
use scene::{Fingers, Grasps, Scene};

/// Largest number of grasps that are checked, spread over the file.
const SAMPLE: usize = 64;
/// Number of sample points along each side of a pad.
const POINTS: usize = 5;

/// Returns a notice if most grasps of the scene's grasp file miss the object or start inside it, which indicates that
/// the poses follow another convention. `pad` is the bounding box of a pad in the pad frame, m.
pub fn aim_notice(scene: &Scene, object: &Shape, pad: Aabb, poses: &[Pose]) -> Option<String> {
    let Grasps::File(file) = &scene.grasps else { return None };
    let closing: &[DVec3] = match scene.gripper.fingers {
        Fingers::Both => &[DVec3::X, DVec3::NEG_X],
        Fingers::One => &[DVec3::X],
        Fingers::None => return None,
    };
    let hand = Hand::new(pad, &scene.gripper);
    let step = poses.len().div_ceil(SAMPLE).max(1);
    let (mut looked_at, mut miss, mut inside) = (0, 0, 0);
    for pose in poses.iter().step_by(step) {
        looked_at += 1;
        match closing.iter().map(|side| cast_closing_rays(object, &hand, pose, *side)).max() {
            Some(RayResult::Inside) => inside += 1,
            Some(RayResult::Nothing) => miss += 1,
            _ => {}
        }
    }
    if 2 * (miss + inside) <= looked_at {
        return None;
    }
    Some(format!(
        "{}: of {looked_at} checked grasps, {miss} miss the object and {inside} start inside it; if the file orders \
         quaternions x y z w, or its hand closes along another axis, set this in the scene: \
         `convention: (quaternion: Xyzw, closing: Y, approach: Z)`",
        file.path.display()
    ))
}

/// Result of closing a pad, ordered from best to worst.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
enum RayResult {
    Object,
    Nothing,
    Inside,
}

/// Casts rays from points of the open pad's face along `closing`, up to the distance between the open pads.
fn cast_closing_rays(object: &Shape, hand: &Hand, pose: &Pose, closing: DVec3) -> RayResult {
    let mut met = RayResult::Nothing;
    for start in hand.face(closing, POINTS).map(|start| pose.transform(start)) {
        if object.distance.distance(start) < 0.0 {
            return RayResult::Inside;
        }
        if object.ray(start, pose.rotation * closing).is_some_and(|hit| hit.t <= hand.opening) {
            met = RayResult::Object;
        }
    }
    met
}
