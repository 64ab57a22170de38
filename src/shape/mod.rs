//! Rigid object shapes: exact signed distance, surface mesh, mass properties.

use glam::{DMat3, DVec3};

/// The closest surface point of a query point `q`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// Signed distance, m; negative inside.
    pub distance: f64,
    /// Gradient of the signed distance at `q`: unit outward normal.
    pub normal: DVec3,
    /// Hessian of the signed distance at `q`, 1/m (surface curvature). Zero where the closest feature is a flat
    /// facet; also zero at the edges and vertices of a mesh, where the true curvature 1/distance is unbounded and
    /// useless to a Newton method.
    pub curvature: DMat3,
}

/// Exact signed distance to a closed surface, in the object's own frame.
pub trait SignedDistance: Send + Sync + std::fmt::Debug {
    /// Signed distance, m. 1-Lipschitz: never larger than the true distance in magnitude.
    fn distance(&self, q: DVec3) -> f64;
    /// Closest point data if the signed distance at `q` is below `max`, else None.
    fn closest(&self, q: DVec3, max: f64) -> Option<Closest>;
}
