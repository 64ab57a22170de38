//! Intersection of rays with convex shapes.

use super::signed_distance::{Hit, MAX_RAY_LENGTH, RAY_TOLERANCE, SignedDistance};
use glam::DVec3;

/// Traces a ray against a convex shape in few steps: the tangent plane at the closest point separates the current point
/// from the shape, so the ray advances to that plane; it misses if it does not approach the plane. This is Newton's
/// method on a convex function.
pub fn trace_convex<D: SignedDistance + ?Sized>(shape: &D, origin: DVec3, direction: DVec3) -> Option<Hit> {
    let dir = direction.try_normalize().filter(|_| origin.is_finite())?;
    let mut t = 0.0;
    for _ in 0..200 {
        let c = shape.closest(origin + t * dir, f64::INFINITY)?;
        let rate = -c.normal.dot(dir);
        if rate <= 0.0 || (t == 0.0 && c.distance < -RAY_TOLERANCE) || t > MAX_RAY_LENGTH {
            return None;
        }
        let step = c.distance / rate;
        t += step.max(0.0);
        if c.distance <= RAY_TOLERANCE && step <= RAY_TOLERANCE.max(4.0 * f64::EPSILON * t) {
            return Some(Hit { t, normal: c.normal });
        }
    }
    None
}
