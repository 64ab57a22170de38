//! Observation of the object's pose in the hand: privileged information for teacher policies and comparisons, which
//! tactile sensors do not measure.

use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};
use scene::leaf::MAX_LENGTH;

/// Observation of the pose of the object frame in the hand frame, array `object_pose` of shape (7): position x, y, z in
/// m, then the unit quaternion w, x, y, z of the rotation from the object to the hand frame, with w >= 0.
#[derive(Debug)]
pub struct PoseInHand;

impl PoseInHand {
    /// Creates the observation; it does not depend on the hand.
    pub fn new(_: &SensorSetup) -> Self {
        Self
    }
}

impl SensorModel for PoseInHand {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("object_pose", &[7], "m, 1", [-MAX_LENGTH, MAX_LENGTH])
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        let (p, q) = (now.frame.object_position, now.frame.object_rotation);
        let q = if q.w < 0.0 { -q } else { q };
        out.iter_mut().zip([p.x, p.y, p.z, q.w, q.x, q.y, q.z]).for_each(|(o, v)| *o = v as f32);
    }
}
