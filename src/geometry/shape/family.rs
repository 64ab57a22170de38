//! Every generated family of objects behind one enum.

use crate::error::Result;
use crate::geometry::shape::{Shape, generate};
use glam::{DVec2, DVec3};

/// A generated object; lengths in metres. Centred at the origin with its axis along z, unless said otherwise.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the fields are named after what they are, and documented where they are used")]
pub enum ShapeKind {
    /// See [`generate::sphere()`].
    Sphere { radius: f64 },
    /// See [`generate::ellipsoid()`].
    Ellipsoid { semi_axes: DVec3 },
    /// See [`generate::cuboid()`].
    Cuboid { size: DVec3, edge_radius: f64 },
    /// See [`generate::cylinder()`].
    Cylinder { radius: f64, height: f64 },
    /// See [`generate::capsule()`].
    Capsule { radius: f64, length: f64 },
    /// See [`generate::prism()`].
    Prism { sides: u32, radius: f64, height: f64 },
    /// See [`generate::annulus()`].
    Annulus { outer_radius: f64, inner_radius: f64, height: f64 },
    /// See [`generate::cup()`].
    Cup { radius: f64, height: f64, wall: f64 },
    /// See [`generate::lemon()`].
    Lemon { length: f64, diameter: f64 },
    /// See [`generate::strawberry()`].
    Strawberry { length: f64, diameter: f64 },
    /// See [`generate::pear()`].
    Pear { length: f64, diameter: f64 },
    /// See [`generate::banana()`].
    Banana { length: f64, diameter: f64, bend: f64 },
    /// See [`generate::potato()`].
    Potato { semi_axes: DVec3, roughness: f64, seed: u64 },
    /// See [`generate::revolve()`].
    Revolve { profile: Vec<DVec2>, closed: bool },
    /// See [`generate::sweep()`].
    Sweep { path: Vec<DVec3>, radii: Vec<f64> },
}

impl ShapeKind {
    /// Makes the object; `segments` divides a full turn of its surface mesh.
    pub fn build(&self, segments: u32) -> Result<Shape> {
        use generate as g;
        match self {
            Self::Sphere { radius } => g::sphere(*radius, segments),
            Self::Ellipsoid { semi_axes } => g::ellipsoid(*semi_axes, segments),
            Self::Cuboid { size, edge_radius } => g::cuboid(*size, *edge_radius, segments),
            Self::Cylinder { radius, height } => g::cylinder(*radius, *height, segments),
            Self::Capsule { radius, length } => g::capsule(*radius, *length, segments),
            Self::Prism { sides, radius, height } => g::prism(*sides, *radius, *height),
            Self::Annulus { outer_radius, inner_radius, height } => {
                g::annulus(*outer_radius, *inner_radius, *height, segments)
            }
            Self::Cup { radius, height, wall } => g::cup(*radius, *height, *wall, segments),
            Self::Lemon { length, diameter } => g::lemon(*length, *diameter, segments),
            Self::Strawberry { length, diameter } => g::strawberry(*length, *diameter, segments),
            Self::Pear { length, diameter } => g::pear(*length, *diameter, segments),
            Self::Banana { length, diameter, bend } => g::banana(*length, *diameter, *bend, segments),
            Self::Potato { semi_axes, roughness, seed } => g::potato(*semi_axes, *roughness, *seed, segments),
            Self::Revolve { profile, closed } => g::revolve("revolve", profile.clone(), *closed, segments),
            Self::Sweep { path, radii } => g::sweep("sweep", path, radii, segments),
        }
    }
}
