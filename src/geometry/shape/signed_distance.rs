//! Signed distance to a closed surface, its closest points, and rays traced through it.

use glam::{DMat3, DVec3};

/// Closest surface point of a query point `q`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Signed distance, m; negative inside.
    pub distance: f64,
    /// Gradient of the signed distance at `q`: unit outward normal.
    pub normal: DVec3,
    /// Hessian of the signed distance at `q`, 1/m (surface curvature). Zero if the closest feature is a flat facet;
    /// also zero at the edges and vertices of a mesh, where the true curvature 1/distance is unbounded and of no use to
    /// Newton's method.
    pub curvature: DMat3,
}

/// Surface points that interact with a query point: the closest point of the surface and, near a concave edge, those of
/// the other incident faces.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPoints {
    /// Closest point.
    pub nearest: SurfacePoint,
    /// Other points within range, each with its weight in the sum over all points (-1 where the incident faces meet);
    /// the weight of the closest point is 1. Their distances are positive.
    pub additional: Vec<(SurfacePoint, f64)>,
}

impl ContactPoints {
    /// Returns all points with their weights, the closest first.
    pub fn points(&self) -> impl Iterator<Item = (&SurfacePoint, f64)> {
        std::iter::once((&self.nearest, 1.0)).chain(self.additional.iter().map(|(c, weight)| (c, *weight)))
    }

    /// Returns the weighted sum over all points.
    pub fn sum(&self, of: impl Fn(&SurfacePoint) -> f64) -> f64 {
        self.points().map(|(c, weight)| weight * of(c)).sum()
    }
}

/// Exact signed distance to a closed surface, in the object's own frame.
pub trait SignedDistance: Send + Sync + std::fmt::Debug {
    /// Returns the signed distance, m. 1-Lipschitz: never larger than the true distance in magnitude.
    fn distance(&self, q: DVec3) -> f64;
    /// Returns closest point data if the signed distance at `q` is below `max`, otherwise None.
    fn closest(&self, q: DVec3, max: f64) -> Option<SurfacePoint>;
    /// Returns the closest point if its signed distance is below `max`, and the other points that interact within the
    /// distance `felt`. By default there are none, which is correct for a smooth surface.
    fn contact_points(&self, q: DVec3, max: f64, _felt: f64) -> Option<ContactPoints> {
        self.closest(q, max).map(|nearest| ContactPoints { nearest, additional: Vec::new() })
    }
    /// Returns the first entry into the object of the ray from `origin` along `direction` (any length > 0), at `t >= 0`
    /// metres. None if the ray misses, starts inside and never re-enters, or is not finite. Default: sphere tracing.
    fn ray(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        trace(self, origin, direction)
    }
    /// Returns a point of the surface farthest along `direction`, m, if it is known in closed form.
    fn support(&self, _direction: DVec3) -> Option<DVec3> {
        None
    }
}

/// Entry of a ray into an object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Length of the ray up to the surface, m.
    pub t: f64,
    /// Unit outward normal there.
    pub normal: DVec3,
}

/// Distance at which the ray has reached the surface, m.
pub(super) const RAY_TOLERANCE: f64 = 1e-12;
/// Length beyond which a ray misses the object, m: no object is longer.
pub(super) const MAX_RAY_LENGTH: f64 = 1e5;

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
        if c.distance.abs() <= RAY_TOLERANCE && entering && (outside || t == 0.0) {
            return Some(Hit { t, normal: c.normal });
        }
        outside |= c.distance > RAY_TOLERANCE;
        if outside && c.distance < -RAY_TOLERANCE {
            // A step crosses the surface only by rounding, so this is the entry.
            return Some(Hit { t, normal: c.normal });
        }
        // The minimum step ensures progress where the ray leaves the object or runs along its surface.
        t += c.distance.abs().max(RAY_TOLERANCE);
        if t > MAX_RAY_LENGTH {
            return None;
        }
    }
    None
}
