//! Check of the equilibrium of a recorded state: elastic forces of its node positions against the external forces on
//! each node.

use super::elasticity::{elastic_gradient, nodal_volume};
use super::penetration::PadSurface;
use crate::part::FingerModel;
use glam::DVec3;
use record::Frame;

/// Returns the largest unbalanced force of a quasi-static frame over the force of a finger. It is the largest of three
/// kinds, none of which evaluates the contact law of the solver: forces on nodes that cannot be in contact (norm over
/// all of them); the reaction of the mount against the load of the finger (summed over the fingers while the object is
/// fixed); the forces on the free surface against the recorded contact force. `gravity` is in the hand frame, m/s2.
pub fn imbalance(fingers: &[FingerModel], surfaces: &[PadSurface], frame: &Frame, gravity: DVec3) -> f64 {
    let load = frame.applied_force / frame.pads.len().max(1) as f64;
    let (mut worst, mut missing) = (0.0_f64, 0.0);
    for ((finger, pad), surface) in fingers.iter().zip(&frame.pads).zip(surfaces) {
        let (body, weight) = (&finger.body, gravity * finger.gel_density);
        let mut force = elastic_gradient(body, &finger.topology.elements, &pad.position);
        let volume = nodal_volume(body, &finger.topology.elements);
        force.iter_mut().zip(&volume).for_each(|(f, volume)| *f -= weight * *volume);
        let (mut inside, mut touching, mut mount) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for (i, f) in force.iter().enumerate() {
            match (body.fixed[i], surface.free[i]) {
                (true, _) => mount += *f,
                (false, true) => touching += *f,
                (false, false) => inside += f.length_squared(),
            }
        }
        // The elastic forces sum to zero, so the mount carries the contact force and the weight of the gel.
        let whole = weight * volume.iter().sum::<f64>();
        // Contact forces on bonded nodes of the rim act directly on the mount.
        let on_mount = pad.contact_force.iter().zip(&body.fixed).filter(|(_, fixed)| **fixed).map(|(f, _)| *f);
        let on_mount: DVec3 = on_mount.sum();
        let closes = (mount + whole - on_mount).dot(finger.placement.closing);
        let contact = pad.wrench.force - on_mount;
        worst = worst.max(inside.sqrt()).max((touching - contact).length());
        if !frame.object_fixed {
            worst = worst.max((closes - load).abs());
        }
        missing += closes - load;
    }
    // While the object is fixed, only the sum over the fingers must balance their loads.
    let worst = worst.max(missing.abs());
    if worst == 0.0 { 0.0 } else { worst / load }
}
