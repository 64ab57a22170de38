//! Signed distance to a capsule.

use crate::shape::sphere::point_curvature;
use crate::shape::{Hit, SignedDistance, SurfacePoint, outer, trace_convex};
use glam::{DMat3, DVec3};

/// Capsule: all points within `radius` of the segment of half length `half` along z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capsule {
    /// Radius, m.
    pub radius: f64,
    /// Half the length of the straight part, m.
    pub half: f64,
}

impl SignedDistance for Capsule {
    fn distance(&self, q: DVec3) -> f64 {
        (q - DVec3::Z * q.z.clamp(-self.half, self.half)).length() - self.radius
    }

    #[inline]
    fn closest(&self, q: DVec3, max: f64) -> Option<SurfacePoint> {
        let away = q - DVec3::Z * q.z.clamp(-self.half, self.half);
        let r = away.length();
        let distance = r - self.radius;
        if !(distance < max) {
            return None;
        }
        let normal = away.try_normalize().unwrap_or(DVec3::X);
        let curvature = if q.z.abs() >= self.half {
            point_curvature(normal, r)
        } else if r > 1e-12 {
            (DMat3::IDENTITY - outer(normal) - outer(DVec3::Z)) * r.recip()
        } else {
            DMat3::ZERO
        };
        Some(SurfacePoint { distance, normal, curvature })
    }

    fn ray(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        trace_convex(self, origin, direction)
    }

    fn support(&self, direction: DVec3) -> Option<DVec3> {
        let n = direction.try_normalize()?;
        Some(self.radius * n + DVec3::Z * self.half.copysign(n.z))
    }
}
