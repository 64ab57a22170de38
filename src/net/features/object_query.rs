//! Queries of the object in the frame of a pad.

use crate::linear_response::first_contact::GeometricContact;
use geometry::Pose;
use glam::{DMat3, DVec3};
use model::Model;
use model::gripper::FingerPlacement;

/// Queries of the object from a pad at first contact.
pub(super) struct ObjectQuery<'a> {
    pub model: &'a Model,
    placement: &'a FingerPlacement,
    /// Displacement of the pad since the hand was open.
    carried: DVec3,
    object: Pose,
    inverse: DMat3,
    /// Rotation from the object frame to the pad frame.
    to_pad: DMat3,
    /// Closing direction in the object frame.
    pub closing: DVec3,
}

impl<'a> ObjectQuery<'a> {
    pub fn new(model: &'a Model, touch: &GeometricContact, placement: &'a FingerPlacement, travel: f64) -> Self {
        let rotation = DMat3::from_quat(touch.object.rotation);
        let inverse = rotation.transpose();
        let carried = placement.closing * travel;
        let to_pad = placement.rotation.transpose() * rotation;
        Self { model, placement, carried, object: touch.object, inverse, to_pad, closing: inverse * placement.closing }
    }

    /// Returns a point of the pad in the object frame.
    pub fn pad_to_object(&self, x: DVec3) -> DVec3 {
        self.inverse * (self.placement.place(x) + self.carried - self.object.position)
    }

    /// Returns a point of the object in the pad frame.
    pub fn object_to_pad(&self, x: DVec3) -> DVec3 {
        let place = self.object.rotation * x + self.object.position - self.carried - self.placement.origin;
        self.placement.rotation.transpose() * place
    }

    /// Returns signed distance, m, and normal of the object in the pad frame, at a point in the object frame.
    pub fn distance_and_normal(&self, at: DVec3) -> (f64, DVec3) {
        let closest = self.model.object.distance.closest(at, f64::INFINITY);
        closest.map_or((f64::MAX, DVec3::ZERO), |c| (c.distance, self.to_pad * c.normal))
    }

    /// Returns the distance along the closing direction to the object, at most `far`, m (sphere tracing, Hart 1996).
    pub fn gap(&self, from: DVec3, far: f64) -> f64 {
        let distance = |t: f64| self.model.object.distance.distance(from + self.closing * t);
        let mut t = 0.0;
        // A grazing ray that reaches this limit is close enough to the object.
        for _ in 0..64 {
            let d = distance(t);
            t += d;
            if d < 1e-4 * far || t >= far {
                break;
            }
        }
        t.min(far)
    }
}
