//! Actions of an agent: numbers from -1 to 1; values outside are clamped.

use geometry::Pose;
use glam::{DQuat, DVec3};
use model::sensors::ArraySpec;
use scene::Task;
use scene::task::Control;

/// Decoded action.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Action {
    /// Sum of the finger forces, N.
    pub force: f64,
    /// Wrist angle about the closing direction since the start, rad.
    pub twist: f64,
    /// Translation (hand axes, m) and rotation of a new grasp relative to the first one; None keeps the grasp.
    pub regrasp: Option<(DVec3, DQuat)>,
}

/// Returns the number of components of an action of `task`.
pub fn size(task: &Task) -> usize {
    1 + usize::from(task.twist_deg.is_some()) + if task.regrasp.is_some() { 3 } else { 0 }
}

/// Returns the specification of the action array of one environment.
pub fn spec(task: &Task) -> ArraySpec {
    ArraySpec::new("action", &[size(task)], "1", [-1.0, 1.0])
}

/// Decodes `numbers` into an action; `force` (N) and `twist` (rad) are those of the previous step.
pub fn decode(task: &Task, numbers: &[f32], force: f64, twist: f64) -> Action {
    let mut numbers = numbers.iter().map(|v| f64::from(*v).clamp(-1.0, 1.0));
    let mut next = || numbers.next().unwrap_or(0.0);
    let [least, most] = [task.force.interpolate(0.0), task.force.interpolate(1.0)];
    let force = match task.control {
        Control::Force => task.force.interpolate(0.5 * (next() + 1.0)),
        Control::Rate(rate) => force + rate.get() * next(),
    };
    let twist = twist + task.twist_deg.map_or(0.0, |most| most.get().to_radians() * next());
    let regrasp = task.regrasp.map(|reach| {
        let shift = DVec3::new(0.0, next(), next()) * reach.shift.get();
        (shift, DQuat::from_rotation_x(next() * reach.turn_deg.get().to_radians()))
    });
    Action { force: force.clamp(least, most), twist, regrasp }
}

/// Returns the hand pose of a new grasp: `first` shifted in hand axes (m) and rotated about `center` (hand frame, m).
pub fn regrasp_pose(first: &Pose, center: DVec3, (shift, turn): (DVec3, DQuat)) -> Pose {
    super::draw::displaced_hand(first, center, shift, turn)
}
