//! Motion quantities for the expectations of a dynamic scene.

use glam::{DQuat, DVec3};
use model::Model;
use model::evaluation::GraspMeasurements;
use record::{DynamicState, Frame};

/// Tally of the motion of an object over the frames of a grasp.
#[derive(Debug, Default)]
pub struct MotionTally {
    /// Reference pose of the object for slip: in the hand frame, or in the world if there are no fingers.
    held: Option<(DVec3, DQuat)>,
}

impl MotionTally {
    /// Adds a frame to the tally.
    pub fn observe(&mut self, m: &mut GraspMeasurements, model: &Model, frame: &Frame, moving: &DynamicState) {
        let Some(dynamics) = &model.dynamics else { return };
        let (position, rotation) = (frame.object_position, frame.object_rotation);
        let center = model.object.mass.center;
        let world = moving.hand_position + moving.hand_rotation * (position + rotation * center);
        m.position_m = world.to_array();
        m.speed_m_s = moving.velocity.length();
        m.ground_force_n = dynamics.support.map_or(f64::NAN, |s| moving.ground_force.dot(s.normal));
        let about = |i: usize| frame.pads[i].wrench.torque.dot(model.fingers[0].placement.closing);
        let torque = (0..frame.pads.len()).map(about).sum::<f64>().abs();
        m.torque_n_m = torque.max(if m.torque_n_m.is_nan() { 0.0 } else { m.torque_n_m });
        m.momentum_drift = drift(model, moving).max(if m.momentum_drift.is_nan() { 0.0 } else { m.momentum_drift });
        // The hand holds an object after squeezing it; without fingers, the world holds it from the start.
        let now = match model.fingers.is_empty() {
            true => (world, moving.hand_rotation * rotation),
            false => (position + rotation * center, rotation),
        };
        if model.fingers.is_empty() {
            self.held.get_or_insert((center, DQuat::IDENTITY));
        } else if dynamics.gripped.is_none_or(|t| frame.time >= t * (1.0 - 1e-9)) {
            self.held.get_or_insert(now);
        }
        if let Some((from, turn)) = self.held {
            let angle = (now.1 * turn.inverse()).to_scaled_axis().length();
            m.last_slip_m = now.0.distance(from) + 2.0 * (0.5 * angle).sin() * model.object.bounding_radius;
            m.slip_m = m.last_slip_m.max(if m.slip_m.is_nan() { 0.0 } else { m.slip_m });
        }
    }
}

/// Returns the larger of the relative changes of linear and angular momentum since the start; NaN if both were zero.
fn drift(model: &Model, moving: &DynamicState) -> f64 {
    let Some(dynamics) = &model.dynamics else { return f64::NAN };
    let inertia = model.object.mass.inertia * (model.mass / model.object.mass.volume);
    let pairs = [(moving.momentum, dynamics.velocity * model.mass), (moving.angular_momentum, inertia * dynamics.spin)];
    let each = pairs.into_iter().filter(|(_, start)| *start != DVec3::ZERO);
    each.map(|(now, start)| now.distance(start) / start.length()).reduce(f64::max).unwrap_or(f64::NAN)
}
