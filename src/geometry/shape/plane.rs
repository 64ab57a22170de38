//! Signed distance to a half-space.

use crate::shape::{Hit, SignedDistance, SurfacePoint, trace_convex};
use base::error::{Error, Result};
use glam::{DMat3, DVec3};

/// Half-space `n . q <= offset`. It is unbounded, so it has no `Shape`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    normal: DVec3,
    offset: f64,
}

impl HalfSpace {
    /// Builds the half-space behind the plane through `point`; `normal` points out of it and may have any length.
    ///
    /// # Errors
    /// Fails if a number is not finite or the normal is zero.
    pub fn new(point: DVec3, normal: DVec3) -> Result<Self> {
        match normal.try_normalize() {
            Some(n) if point.is_finite() => Ok(Self { normal: n, offset: n.dot(point) }),
            _ => Err(Error::Mesh(format!(
                "plane: point {point} and normal {normal} must be finite, the normal not zero"
            ))),
        }
    }
}

impl SignedDistance for HalfSpace {
    fn distance(&self, q: DVec3) -> f64 {
        self.normal.dot(q) - self.offset
    }

    #[inline]
    fn closest(&self, q: DVec3, max: f64) -> Option<SurfacePoint> {
        let distance = self.distance(q);
        (distance < max).then_some(SurfacePoint { distance, normal: self.normal, curvature: DMat3::ZERO })
    }

    fn ray(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        trace_convex(self, origin, direction)
    }
}
