//! Signed distance to a box, with sharp or rounded edges.

use crate::shape::{Hit, SignedDistance, SurfacePoint, outer, trace_convex};
use glam::{DMat3, DVec3};

/// Box about the origin: all points within `radius` of the core box of half sizes `core`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cuboid {
    /// Half sizes of the core, m: half the outer sizes minus `radius`.
    pub core: DVec3,
    /// Edge radius, m; 0 for sharp edges.
    pub radius: f64,
}

impl SignedDistance for Cuboid {
    fn distance(&self, q: DVec3) -> f64 {
        let w = q.abs() - self.core;
        w.max(DVec3::ZERO).length() + w.max_element().min(0.0) - self.radius
    }

    #[inline]
    fn closest(&self, q: DVec3, max: f64) -> Option<SurfacePoint> {
        let w = q.abs() - self.core;
        if !(w.max_element() - self.radius < max) {
            return None;
        }
        let sign = DVec3::ONE.copysign(q);
        let out = w.max(DVec3::ZERO);
        let active = out.cmpgt(DVec3::ZERO);
        let (distance, normal, curvature) = if active.any() {
            let r = out.length();
            let n = sign * out / r;
            // Around a rounded edge or corner the distance is that to the core's edge or corner, less the radius.
            let round = if self.radius > 0.0 && active.bitmask().count_ones() > 1 {
                let span = DVec3::select(active, DVec3::ONE, DVec3::ZERO);
                (DMat3::from_diagonal(span) - outer(n)) * r.recip()
            } else {
                DMat3::ZERO
            };
            (r - self.radius, n, round)
        } else {
            let axis = w.max_position();
            (w[axis] - self.radius, DVec3::AXES[axis] * sign, DMat3::ZERO)
        };
        (distance < max).then_some(SurfacePoint { distance, normal, curvature })
    }

    fn ray(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        trace_convex(self, origin, direction)
    }

    fn support(&self, direction: DVec3) -> Option<DVec3> {
        Some(self.core.copysign(direction) + self.radius * direction.try_normalize()?)
    }
}
