//! Signed distance to a sphere.

use crate::shape::{Hit, SignedDistance, SurfacePoint, outer, trace_convex};
use glam::{DMat3, DVec3};

/// Sphere about the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// Radius, m.
    pub radius: f64,
}

/// Computes `(I - n n^T) / r`, the Hessian of the distance to a point at distance `r`; zero at the point itself.
pub(crate) fn point_curvature(n: DVec3, r: f64) -> DMat3 {
    if r > 1e-12 { (DMat3::IDENTITY - outer(n)) * r.recip() } else { DMat3::ZERO }
}

impl SignedDistance for Sphere {
    fn distance(&self, q: DVec3) -> f64 {
        q.length() - self.radius
    }

    #[inline]
    fn closest(&self, q: DVec3, max: f64) -> Option<SurfacePoint> {
        let r = q.length();
        let distance = r - self.radius;
        if !(distance < max) {
            return None;
        }
        let normal = q.try_normalize().unwrap_or(DVec3::Z);
        Some(SurfacePoint { distance, normal, curvature: point_curvature(normal, r) })
    }

    fn ray(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        trace_convex(self, origin, direction)
    }

    fn support(&self, direction: DVec3) -> Option<DVec3> {
        Some(self.radius * direction.try_normalize()?)
    }
}
