//! Rotation of the hand.

use super::profile::{HandState, MotionContext, MotionProfile, minimum_jerk};
use crate::leaf::{Finite, Seconds};
use crate::vector::Direction;
use geometry::Pose;
use glam::DQuat;
use serde::{Deserialize, Serialize};

/// Rotates the hand about an axis through the point midway between the pads, starting and ending at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rotate {
    /// Angle, degrees, right-handed.
    pub angle_deg: Finite,
    /// Axis in the hand frame, of any nonzero length: (1, 0, 0) is the closing direction, (0, 0, 1) the approach.
    pub axis: Direction,
    /// Duration, s.
    pub duration: Seconds,
}

impl MotionProfile for Rotate {
    fn duration(&self) -> f64 {
        self.duration.get()
    }

    fn hand_state(&self, start: &HandState, time: f64, stage: &MotionContext) -> HandState {
        let angle = self.angle_deg.get().to_radians() * minimum_jerk(time / self.duration());
        let rotation = (start.pose.rotation * DQuat::from_axis_angle(self.axis.unit(), angle)).normalize();
        // The point midway between the pads is the centre of rotation.
        let position = start.pose.transform(stage.center) - rotation * stage.center;
        HandState { pose: Pose { position, rotation }, ..*start }
    }
}
