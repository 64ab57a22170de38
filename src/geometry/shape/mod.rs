//! Rigid object shapes: exact signed distance, surface mesh, mass properties, sharp features, rays.
//!
//! [`Shape`] bundles them; [`ShapeKind`] enumerates the generated families, and [`Shape::from_mesh`] accepts any closed
//! mesh. All lengths are metres, in the object's own frame.

#![allow(clippy::neg_cmp_op_on_partial_ord, reason = "a value that is not a number must fail every test")]

mod bvh;
pub mod capsule;
pub mod cuboid;
pub mod cylinder;
pub mod ellipsoid;
mod facet;
mod family;
mod feature_point;
pub mod features;
pub mod generate;
mod lattice;
pub mod level_set;
pub mod mass;
pub mod mesh_distance;
mod outer_product;
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
mod signed_distance;
pub mod smooth;
mod solid;
pub mod sphere;
mod surface_definition;
mod surface_distance;
mod topology;
mod valid_surface;
mod validity;
pub(crate) mod winding;

pub use family::ShapeKind;
pub use feature_point::FeaturePoint;
pub use features::{ConvexEdge, EdgeSection, RoundedEdge, SurfaceFeatures};
pub use mass::MassProperties;
pub use mesh_distance::MeshDistance;
pub use outer_product::outer;
pub use params::{DEFAULT_SEGMENTS, MAX_SEGMENTS, MIN_SEGMENTS};
pub use ray::trace_convex;
pub use signed_distance::{ContactPoints, Hit, SignedDistance, SurfacePoint, trace};
pub use solid::Shape;
pub use surface_definition::{SmoothSurface, SurfaceDefinition};
pub use surface_distance::SurfaceDistance;
pub use valid_surface::valid_surface;
