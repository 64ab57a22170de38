//! Rays against signed distances.

use crate::geometry::shape::SignedDistance;
use glam::DVec3;

/// Entrance of a ray into an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Length of the ray up to the surface, m.
    pub t: f64,
    /// Unit outward normal there.
    pub normal: DVec3,
}

/// Distance at which the ray counts as arrived, m.
const ARRIVED: f64 = 1e-12;
/// Length after which a ray has missed, m: no object is longer.
const FAR: f64 = 1e5;

/// Traces spheres along the ray (Hart 1996): a step as long as the distance cannot pass through the surface. It works on
/// any shape and takes many steps where the ray grazes it. A ray that starts inside first leaves, then looks for its next
/// entrance.
pub fn trace<D: SignedDistance + ?Sized>(shape: &D, origin: DVec3, direction: DVec3) -> Option<Hit> {
    let dir = direction.try_normalize().filter(|_| origin.is_finite())?;
    let mut t = 0.0;
    let mut outside = false;
    for _ in 0..20_000 {
        let c = shape.closest(origin + t * dir, f64::INFINITY)?;
        let entering = c.normal.dot(dir) < 0.0;
        if c.distance.abs() <= ARRIVED && entering && (outside || t == 0.0) {
            return Some(Hit { t, normal: c.normal });
        }
        outside |= c.distance > ARRIVED;
        if outside && c.distance < -ARRIVED {
            // Only rounding can carry a step across: the surface is right here.
            return Some(Hit { t, normal: c.normal });
        }
        // The least step keeps a ray that leaves, or slides along the surface, from standing still.
        t += c.distance.abs().max(ARRIVED);
        if t > FAR {
            return None;
        }
    }
    None
}

/// Traces a ray against a convex shape in a handful of steps: the tangent plane at the closest point separates, so the ray may go up to
/// that plane, and has missed once it no longer approaches it. This is Newton's method on a convex function.
pub fn trace_convex<D: SignedDistance + ?Sized>(shape: &D, origin: DVec3, direction: DVec3) -> Option<Hit> {
    let dir = direction.try_normalize().filter(|_| origin.is_finite())?;
    let mut t = 0.0;
    for _ in 0..200 {
        let c = shape.closest(origin + t * dir, f64::INFINITY)?;
        let rate = -c.normal.dot(dir);
        if rate <= 0.0 || (t == 0.0 && c.distance < -ARRIVED) || t > FAR {
            return None;
        }
        let step = c.distance / rate;
        t += step.max(0.0);
        if c.distance <= ARRIVED && step <= ARRIVED.max(4.0 * f64::EPSILON * t) {
            return Some(Hit { t, normal: c.normal });
        }
    }
    None
}
