//! Exact signed distance to a solid of revolution about z.
//!
//! The closest point lies in the meridian half-plane of the query, so the distance is that to the 2D profile there.

use crate::shape::polygon::Profile;
use crate::shape::{SignedDistance, SurfacePoint, outer};
use glam::{DMat3, DVec2, DVec3, Vec3Swizzles};

/// Solid of revolution about z with a polygonal profile.
#[derive(Debug, Clone, PartialEq)]
pub struct Revolved {
    profile: Profile,
    low: DVec2,
    high: DVec2,
}

impl Revolved {
    /// Builds the solid of revolution of `profile` about z.
    pub fn new(profile: Profile) -> Self {
        let (low, high) = profile.bounds();
        Self { profile, low, high }
    }

    /// Returns the profile.
    pub fn profile(&self) -> &Profile {
        &self.profile
    }
}

impl SignedDistance for Revolved {
    fn distance(&self, q: DVec3) -> f64 {
        let flat = DVec2::new(q.xy().length(), q.z);
        self.profile.nearest(flat, f64::INFINITY).map_or(f64::NAN, |p| p.distance)
    }

    fn closest(&self, q: DVec3, max: f64) -> Option<SurfacePoint> {
        let flat = DVec2::new(q.xy().length(), q.z);
        let gap = (self.low - flat).max(flat - self.high).max_element();
        if !(gap < max || max <= 0.0) {
            return None;
        }
        // Outside the bounding box, distances beyond `max` are irrelevant; inside it the point may be deep in the
        // solid.
        let limit = if gap > 0.0 { max * max * (1.0 + 1e-12) } else { f64::INFINITY };
        let p = self.profile.nearest(flat, limit)?;
        if !(p.distance < max) {
            return None;
        }
        let radial = DVec3::new(q.x, q.y, 0.0).try_normalize().unwrap_or(DVec3::X);
        let around = DVec3::new(-radial.y, radial.x, 0.0);
        let curvature = if p.smooth && flat.x > 1e-12 { outer(around) * (p.normal.x / flat.x) } else { DMat3::ZERO };
        Some(SurfacePoint { distance: p.distance, normal: p.normal.x * radial + p.normal.y * DVec3::Z, curvature })
    }

    fn support(&self, direction: DVec3) -> Option<DVec3> {
        self.profile.support(direction)
    }
}
