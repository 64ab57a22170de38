//! Grasp quality: slip of the object over the pads, and friction margin of the grip.

use glam::DVec3;
use model::Model;
use net::linear_response::limit_surface::LimitSurface;
use record::Frame;

/// Returns the fraction of the friction limit that `load` (N, hand frame, at the object's centre of mass) leaves
/// unused: 1 without load, 0 at gross slip, negative beyond.
pub fn margin(model: &Model, friction: f64, frame: &Frame, load: DVec3) -> f64 {
    let Some(finger) = model.fingers.first() else { return 1.0 };
    let presses = frame.pads.iter().zip(&model.fingers).flat_map(|(pad, finger)| {
        let closing = finger.placement.closing;
        pad.contact_force.iter().zip(&pad.position).map(move |(f, x)| ((-f.dot(closing)).max(0.0), *x))
    });
    let mass = frame.object_position + frame.object_rotation * model.object.mass.center;
    1.0 - LimitSurface::new(finger.placement.closing, presses).used(friction, load, mass, DVec3::ZERO).whole
}

/// Returns the slip of the object over the pads between two frames, perpendicular to the closing direction, m. It is
/// the mean over the pads of the relative motion of the nodes in contact, weighted by the normal force in `before`.
pub fn slip(model: &Model, before: &Frame, now: &Frame) -> f64 {
    let carried = |x: DVec3| {
        let own = before.object_rotation.inverse() * (x - before.object_position);
        now.object_rotation * own + now.object_position - x
    };
    let pad = |i: usize| {
        let (closing, old, new) = (model.fingers[i].placement.closing, &before.pads[i], &now.pads[i]);
        let (mut way, mut whole) = (DVec3::ZERO, 0.0);
        for ((force, x), y) in old.contact_force.iter().zip(&old.position).zip(&new.position) {
            let pressure = (-force.dot(closing)).max(0.0);
            if pressure > 0.0 {
                way += (carried(*x) - (*y - *x)) * pressure;
                whole += pressure;
            }
        }
        let way = way - closing * way.dot(closing);
        if whole > 0.0 { way.length() / whole } else { 0.0 }
    };
    (0..now.pads.len()).map(pad).sum::<f64>() / now.pads.len().max(1) as f64
}
