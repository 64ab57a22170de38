//! Cylinders.

use crate::shape::cylinder::Cylinder;
use crate::shape::generate::revolved_mesh;
use crate::shape::params::{check_length, check_segments as turn};
use crate::shape::polygon::Profile;
use crate::shape::rod::Rod;
use crate::shape::{MassProperties, Shape, SurfaceFeatures};
use base::error::Result;
use glam::DVec2;

/// Builds a cylinder with sharp rims; radius and height in m.
///
/// # Errors
/// Fails if a parameter is out of range.
pub fn cylinder(radius: f64, height: f64, segments: u32) -> Result<Shape> {
    check_length("cylinder", "radius", radius)?;
    check_length("cylinder", "height", height)?;
    let half = height / 2.0;
    let points = [(0.0, -half), (radius, -half), (radius, half), (0.0, half)].map(DVec2::from);
    let profile = Profile::new("cylinder", points.to_vec(), false)?;
    let mesh = revolved_mesh(&profile, turn("cylinder", segments)?);
    let rod = Some(Rod { radius, half, capped: false });
    let features = SurfaceFeatures { rod, ..SurfaceFeatures::of_profile(&profile, segments) };
    let mass = MassProperties::of_profile(&profile);
    Ok(Shape::closed_form("cylinder", Cylinder { radius, half }, mesh, features, mass, radius.hypot(half)))
}
