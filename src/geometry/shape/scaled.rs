//! Uniformly scaled shape.

use crate::shape::{ContactPoints, Hit, SignedDistance, SurfacePoint};
use glam::DVec3;
use std::sync::Arc;

/// Shape `inner` scaled by `factor` about the origin: `d(q) = factor * inner(q / factor)`.
#[derive(Debug)]
pub(crate) struct Scaled {
    pub inner: Arc<dyn SignedDistance>,
    pub factor: f64,
}

impl Scaled {
    fn magnified(&self, c: SurfacePoint) -> SurfacePoint {
        SurfacePoint {
            distance: self.factor * c.distance,
            normal: c.normal,
            curvature: c.curvature * self.factor.recip(),
        }
    }
}

impl SignedDistance for Scaled {
    fn distance(&self, q: DVec3) -> f64 {
        self.factor * self.inner.distance(q / self.factor)
    }

    fn closest(&self, q: DVec3, max: f64) -> Option<SurfacePoint> {
        self.inner.closest(q / self.factor, max / self.factor).map(|c| self.magnified(c))
    }

    fn contact_points(&self, q: DVec3, max: f64, felt: f64) -> Option<ContactPoints> {
        let touch = self.inner.contact_points(q / self.factor, max / self.factor, felt / self.factor)?;
        let beside = touch.additional.into_iter().map(|(c, weight)| (self.magnified(c), weight)).collect();
        Some(ContactPoints { nearest: self.magnified(touch.nearest), additional: beside })
    }

    fn ray(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let hit = self.inner.ray(origin / self.factor, direction)?;
        Some(Hit { t: self.factor * hit.t, normal: hit.normal })
    }

    fn support(&self, direction: DVec3) -> Option<DVec3> {
        Some(self.factor * self.inner.support(direction)?)
    }
}
