//! Ellipsoids.

use crate::shape::ellipsoid::Ellipsoid;
use crate::shape::generate::icosphere;
use crate::shape::params::{check_length, check_segments as turn, require};
use crate::shape::{MassProperties, Shape, SurfaceFeatures};
use base::error::Result;
use glam::DVec3;

/// Builds an ellipsoid with the given semi-axes along x, y, z, m; the longest is at most 1,000 times the shortest.
///
/// # Errors
/// Fails if a parameter is out of range or the semi-axes differ too much.
pub fn ellipsoid(semi: DVec3, segments: u32) -> Result<Shape> {
    for (axis, value) in ["x", "y", "z"].into_iter().zip(semi.to_array()) {
        check_length("ellipsoid", &format!("semi-axis {axis}"), value)?;
    }
    require("ellipsoid", semi.max_element() <= 1e3 * semi.min_element(), || {
        format!("semi-axes {semi} m differ by more than a factor of 1000")
    })?;
    let mut mesh = icosphere(turn("ellipsoid", segments)?);
    mesh.vertices.iter_mut().for_each(|p| *p *= semi);
    let mass = MassProperties::of_ellipsoid(semi);
    Ok(Shape::closed_form("ellipsoid", Ellipsoid { semi }, mesh, SurfaceFeatures::default(), mass, semi.max_element()))
}
