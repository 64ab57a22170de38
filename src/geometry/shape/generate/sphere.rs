//! Spheres.

use crate::shape::generate::icosphere;
use crate::shape::params::{check_length, check_segments as turn};
use crate::shape::sphere::Sphere;
use crate::shape::{MassProperties, Shape, SurfaceFeatures};
use base::error::Result;
use glam::DVec3;

/// Builds a sphere; radius in m.
///
/// # Errors
/// Fails if a parameter is out of range.
pub fn sphere(radius: f64, segments: u32) -> Result<Shape> {
    check_length("sphere", "radius", radius)?;
    let mut mesh = icosphere(turn("sphere", segments)?);
    mesh.vertices.iter_mut().for_each(|p| *p *= radius);
    let mass = MassProperties::of_ellipsoid(DVec3::splat(radius));
    Ok(Shape::closed_form("sphere", Sphere { radius }, mesh, SurfaceFeatures::of_rod(radius, 0.0), mass, radius))
}
