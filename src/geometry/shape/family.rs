//! Families of generated objects in one enum.

use crate::shape::{Shape, generate};
use base::error::Result;
use glam::{DVec2, DVec3};

/// Generated object; lengths in metres. It is centred at the origin with its axis along z unless stated otherwise.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "the names of the fields describe them, and they are documented where they are used")]
pub enum ShapeKind {
    /// Sphere, see [`generate::sphere()`].
    Sphere { radius: f64 },
    /// Ellipsoid, see [`generate::ellipsoid()`].
    Ellipsoid { semi_axes: DVec3 },
    /// Box, see [`generate::cuboid()`].
    Cuboid { size: DVec3, edge_radius: f64 },
    /// Cylinder, see [`generate::cylinder()`].
    Cylinder { radius: f64, height: f64 },
    /// Capsule, see [`generate::capsule()`].
    Capsule { radius: f64, length: f64 },
    /// Prism, see [`generate::prism()`].
    Prism { sides: u32, radius: f64, height: f64 },
    /// Hollow cylinder, see [`generate::annulus()`].
    Annulus { outer_radius: f64, inner_radius: f64, height: f64 },
    /// Cup, see [`generate::cup()`].
    Cup { radius: f64, height: f64, wall: f64 },
    /// Lemon, see [`generate::lemon()`].
    Lemon { length: f64, diameter: f64 },
    /// Strawberry, see [`generate::strawberry()`].
    Strawberry { length: f64, diameter: f64 },
    /// Pear, see [`generate::pear()`].
    Pear { length: f64, diameter: f64 },
    /// Banana, see [`generate::banana()`].
    Banana { length: f64, diameter: f64, bend: f64 },
    /// Potato, see [`generate::potato()`].
    Potato { semi_axes: DVec3, roughness: f64, seed: u64 },
    /// Solid of revolution, see [`generate::revolve()`].
    Revolve { profile: Vec<DVec2>, closed: bool },
    /// Swept tube, see [`generate::sweep()`].
    Sweep { path: Vec<DVec3>, radii: Vec<f64> },
}

impl ShapeKind {
    /// Builds the object; `segments` is the number of divisions of a full turn in its surface mesh.
    ///
    /// # Errors
    /// Fails if a parameter is out of range or the surface does not bound a solid.
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
