//! Rigid motion of the object, measured at its point midway between the pads.

use geometry::Pose;
use glam::{DMat3, DQuat, DVec3};
use model::Model;

/// Computes the motion of the object from `start` to `now`, in the axes of a pad: translation of its point midway
/// between the pads, m, and rotation vector.
pub fn rigid_motion(model: &Model, start: &Pose, now: &Pose, pad: DMat3) -> (DVec3, DVec3) {
    let turn = (now.rotation * start.rotation.inverse()).normalize();
    let turn = if turn.w < 0.0 { -turn } else { turn };
    let point = model.midpoint_between_pads();
    let shift = turn * (point - start.position) + now.position - point;
    (pad.transpose() * shift, pad.transpose() * turn.to_scaled_axis())
}

/// Returns the pose after such a motion from `start`; shift (m) and rotation vector in hand axes.
pub fn pose_after_motion(model: &Model, start: &Pose, shift: DVec3, turn: DVec3) -> Pose {
    let point = model.midpoint_between_pads();
    let turn = DQuat::from_scaled_axis(turn);
    Pose { position: point + shift - turn * (point - start.position), rotation: (turn * start.rotation).normalize() }
}
