//! Intersection of rays with signed distances.

use crate::shape::SignedDistance;
use glam::DVec3;

/// Entry of a ray into an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Length of the ray up to the surface, m.
    pub t: f64,
    /// Unit outward normal there.
    pub normal: DVec3,
}

/// Distance at which the ray has reached the surface, m.
const TOLERANCE: f64 = 1e-12;
/// Length beyond which a ray misses the object, m: no object is longer.
const FAR: f64 = 1e5;

/// Traces a ray by sphere tracing (Hart 1996): a step as long as the distance cannot pass through the surface. It works
/// for any shape and takes many steps at grazing incidence. A ray that starts inside must leave the object before its
/// entry is found.
pub fn trace<D: SignedDistance + ?Sized>(shape: &D, origin: DVec3, direction: DVec3) -> Option<Hit> {
    let dir = direction.try_normalize().filter(|_| origin.is_finite())?;
    let mut t = 0.0;
    let mut outside = false;
    for _ in 0..20_000 {
        let c = shape.closest(origin + t * dir, f64::INFINITY)?;
        let entering = c.normal.dot(dir) < 0.0;
        if c.distance.abs() <= TOLERANCE && entering && (outside || t == 0.0) {
            return Some(Hit { t, normal: c.normal });
        }
        outside |= c.distance > TOLERANCE;
        if outside && c.distance < -TOLERANCE {
            // A step crosses the surface only by rounding, so this is the entry.
            return Some(Hit { t, normal: c.normal });
        }
        // The minimum step ensures progress where the ray leaves the object or runs along its surface.
        t += c.distance.abs().max(TOLERANCE);
        if t > FAR {
            return None;
        }
    }
    None
}

/// Traces a ray against a convex shape in few steps: the tangent plane at the closest point separates the current point
/// from the shape, so the ray advances to that plane; it misses if it does not approach the plane. This is Newton's
/// method on a convex function.
pub fn trace_convex<D: SignedDistance + ?Sized>(shape: &D, origin: DVec3, direction: DVec3) -> Option<Hit> {
    let dir = direction.try_normalize().filter(|_| origin.is_finite())?;
    let mut t = 0.0;
    for _ in 0..200 {
        let c = shape.closest(origin + t * dir, f64::INFINITY)?;
        let rate = -c.normal.dot(dir);
        if rate <= 0.0 || (t == 0.0 && c.distance < -TOLERANCE) || t > FAR {
            return None;
        }
        let step = c.distance / rate;
        t += step.max(0.0);
        if c.distance <= TOLERANCE && step <= TOLERANCE.max(4.0 * f64::EPSILON * t) {
            return Some(Hit { t, normal: c.normal });
        }
    }
    None
}
