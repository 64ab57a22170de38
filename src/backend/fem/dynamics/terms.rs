//! Terms that dynamics adds to those of a quasi-static scene.

use base::scales::STOP_PENETRATION;
use geometry::Pose;
use mech::contact::GroundContact;
use mech::newton::Newton;
use mech::potential::drive::Drive;
use mech::potential::pad_inertia::PadInertia;
use mech::potential::rigid_inertia::RigidInertia;
use mech::potential::state::State;
use mech::potential::viscosity::Viscosity;
use model::{Dynamics, Model};

/// Adds the terms for a start from `state` with the hand at `hand`. Everything is at rest except an object with initial
/// velocity.
pub fn add(newton: &mut Newton, model: &Model, dynamics: &Dynamics, state: &State, hand: Pose) {
    for (i, finger) in model.fingers.iter().enumerate() {
        let (body, view) = (&finger.body, state.view(i, &newton.rigid));
        let terms = &mut newton.terms[i];
        terms.push(Box::new(PadInertia::new(body, finger.gel_density, dynamics.gravity, hand, &view)));
        if dynamics.damping > 0.0 {
            terms.push(Box::new(Viscosity::new(body, dynamics.damping, view.x)));
        }
        if dynamics.squeezes() {
            let rated = dynamics.rated_force / model.fingers.len() as f64;
            let yields = STOP_PENETRATION * model.offset;
            terms.push(Box::new(Drive::new(rated, dynamics.closing_speed, model.stroke, yields, state.travel[i])));
        }
    }
    if !model.free {
        return;
    }
    let view = state.object_view(&newton.rigid);
    let moving = (dynamics.velocity, dynamics.spin);
    let density = model.mass / model.object.mass.volume;
    let inertia = RigidInertia::new(&model.object.mass, density, dynamics.gravity, moving, hand, &view);
    newton.object.inertia = Some(inertia);
    if let Some(s) = &dynamics.support {
        let vertices = model.object.surface.vertices.iter().copied().collect();
        newton.object.ground = Some(GroundContact::new(vertices, s.law, s.normal, s.height, hand, &view));
    }
}
