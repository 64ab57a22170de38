//! Friction margin of the pads on the object, from the predicted pressure.

use super::contact_correction::object_pose;
use super::predicted_state::GraspState;
use crate::linear_response::GraspLoad;
use crate::linear_response::first_contact::GeometricContact;
use crate::linear_response::limit_surface::LimitSurface;
use geometry::Wrench;
use glam::DVec3;
use model::Model;

/// Returns true if weight or a push acts on the object of a grasp with first contact `touch`.
pub fn carries_load(touch: &GeometricContact, load: &GraspLoad) -> bool {
    touch.weight != DVec3::ZERO || load.push != Wrench::ZERO
}

/// Returns the remaining fraction of the friction limit under weight and push, in a state of a grasp with first contact
/// `touch`: 1 without these loads or for an object that is fixed or supported, negative where the object slips.
pub fn friction_margin(model: &Model, touch: &GeometricContact, state: &GraspState, load: &GraspLoad) -> f64 {
    // Until its release, an object is carried by its support.
    let held = !model.free || state.held || !carries_load(touch, load);
    let (Some(finger), false) = (model.fingers.first(), held) else { return 1.0 };
    let presses = model.fingers.iter().zip(&state.pads).zip(&touch.travel).flat_map(|((finger, pad), first)| {
        let carried = finger.placement.closing * (first + pad.travel);
        let nodes = finger.topology.rest.iter().zip(&pad.displacement).zip(&pad.contact);
        nodes.map(move |((x, u), force)| ((-force.z).max(0.0), finger.placement.place(*x + *u) + carried))
    });
    let object = object_pose(model, touch, &state.pads);
    let mass = object.position + object.rotation * model.object.mass.center;
    let surface = LimitSurface::new(finger.placement.closing, presses);
    surface.margin(model.friction, touch.weight + load.push.force, mass, load.push.torque)
}

/// Returns why a grasp with this [`friction_margin`] is dropped; None if it is not.
pub fn slip_reason(margin: f64) -> Option<String> {
    let part = 100.0 * (1.0 - margin);
    let message = "of the friction limit at the predicted pressure";
    (margin < 0.0).then(|| format!("the object slips: weight and push are {part:.0} % {message}"))
}
