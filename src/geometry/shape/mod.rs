//! Rigid object shapes: exact signed distance, surface mesh, mass properties, sharp features, rays.
//!
//! [`Shape`] bundles them; [`ShapeKind`] enumerates the generated families, and [`Shape::from_mesh`] accepts any closed
//! mesh. All lengths are metres, in the object's own frame.

#![allow(clippy::neg_cmp_op_on_partial_ord, reason = "a value that is not a number must fail every test")]

use glam::{DMat3, DVec3};

mod bvh;
pub mod capsule;
pub mod cuboid;
pub mod cylinder;
pub mod ellipsoid;
mod facet;
mod family;
pub mod features;
pub mod generate;
mod lattice;
pub mod level_set;
pub mod mass;
pub mod mesh_distance;
pub(crate) mod overlap;
mod params;
pub mod plane;
pub mod polygon;
mod ray;
mod repair;
pub mod revolved;
mod ring;
mod rod;
mod scaled;
pub mod smooth;
mod solid;
mod sound;
pub mod sphere;
mod surface_distance;
mod topology;
pub(crate) mod winding;

pub use family::ShapeKind;
pub use features::{FeaturePoint, Ridge, RidgeSection, RoundedEdge, SurfaceFeatures};
pub use mass::MassProperties;
pub use mesh_distance::MeshDistance;
pub use params::{DEFAULT_SEGMENTS, MAX_SEGMENTS, MIN_SEGMENTS};
pub use ray::{Hit, trace, trace_convex};
pub use smooth::{SmoothSurface, SurfaceDefinition};
pub use solid::Shape;
pub use sound::sound;
pub use surface_distance::SurfaceDistance;

/// Closest surface point of a query point `q`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
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
    pub nearest: Closest,
    /// Other points within range, each with its weight in the sum over all points (-1 where the incident faces meet);
    /// the weight of the closest point is 1. Their distances are positive.
    pub beside: Vec<(Closest, f64)>,
}

impl ContactPoints {
    /// Returns all points with their weights, the closest first.
    pub fn places(&self) -> impl Iterator<Item = (&Closest, f64)> {
        std::iter::once((&self.nearest, 1.0)).chain(self.beside.iter().map(|(c, weight)| (c, *weight)))
    }

    /// Returns the weighted sum over all points.
    pub fn sum(&self, of: impl Fn(&Closest) -> f64) -> f64 {
        self.places().map(|(c, weight)| weight * of(c)).sum()
    }
}

/// Exact signed distance to a closed surface, in the object's own frame.
pub trait SignedDistance: Send + Sync + std::fmt::Debug {
    /// Returns the signed distance, m. 1-Lipschitz: never larger than the true distance in magnitude.
    fn distance(&self, q: DVec3) -> f64;
    /// Returns closest point data if the signed distance at `q` is below `max`, otherwise None.
    fn closest(&self, q: DVec3, max: f64) -> Option<Closest>;
    /// Returns the closest point if its signed distance is below `max`, and the other points that interact within the
    /// distance `felt`. By default there are none, which is correct for a smooth surface.
    fn touch(&self, q: DVec3, max: f64, _felt: f64) -> Option<ContactPoints> {
        self.closest(q, max).map(|nearest| ContactPoints { nearest, beside: Vec::new() })
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

/// Computes `n n^T`, the projection onto the unit vector `n`.
pub fn outer(n: DVec3) -> DMat3 {
    DMat3::from_cols(n * n.x, n * n.y, n * n.z)
}
