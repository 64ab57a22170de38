//! Signed distance to a circular cylinder with flat ends.

use crate::shape::{Hit, SignedDistance, SurfacePoint, outer, trace_convex};
use glam::{DMat3, DVec3};

/// Cylinder along z about the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    /// Radius, m.
    pub radius: f64,
    /// Half the height, m.
    pub half: f64,
}

impl SignedDistance for Cylinder {
    fn distance(&self, q: DVec3) -> f64 {
        let (s, e) = (q.x.hypot(q.y) - self.radius, q.z.abs() - self.half);
        if s > 0.0 && e > 0.0 { s.hypot(e) } else { s.max(e) }
    }

    #[inline]
    fn closest(&self, q: DVec3, max: f64) -> Option<SurfacePoint> {
        let rho = q.x.hypot(q.y);
        // Signed distances to the lateral surface and to the nearer end plane.
        let (s, e) = (rho - self.radius, q.z.abs() - self.half);
        if !(s.max(e) < max) {
            return None;
        }
        let radial = DVec3::new(q.x, q.y, 0.0).try_normalize().unwrap_or(DVec3::X);
        let axial = DVec3::Z * 1.0_f64.copysign(q.z);
        let (distance, normal, curvature) = if s > 0.0 && e > 0.0 {
            let d = s.hypot(e);
            (d, (s * radial + e * axial) / d, DMat3::ZERO)
        } else if s >= e {
            let round = if rho > 1e-12 {
                (DMat3::IDENTITY - outer(radial) - outer(DVec3::Z)) * rho.recip()
            } else {
                DMat3::ZERO
            };
            (s, radial, round)
        } else {
            (e, axial, DMat3::ZERO)
        };
        (distance < max).then_some(SurfacePoint { distance, normal, curvature })
    }

    fn ray(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        trace_convex(self, origin, direction)
    }

    fn support(&self, direction: DVec3) -> Option<DVec3> {
        let radial = DVec3::new(direction.x, direction.y, 0.0).normalize_or_zero();
        Some(self.radius * radial + DVec3::Z * self.half.copysign(direction.z))
    }
}
