//! Capsules.

use crate::shape::capsule::Capsule;
use crate::shape::generate::{revolved_mesh, sphere};
use crate::shape::params::{check_length as check, check_segments as turn, require};
use crate::shape::polygon::Profile;
use crate::shape::{MassProperties, Shape, SurfaceFeatures};
use base::error::Result;
use glam::DVec2;
use std::f64::consts::PI;

/// Builds a capsule: radius and overall length (at least the diameter) in m.
///
/// # Errors
/// Fails if a parameter is out of range or the length is below the diameter.
pub fn capsule(radius: f64, length: f64, segments: u32) -> Result<Shape> {
    check("capsule", "radius", radius)?;
    check("capsule", "length", length)?;
    let half = length / 2.0 - radius;
    require("capsule", half >= 0.0, || format!("length {length} m must be at least twice the radius {radius} m"))?;
    if half < 1e-6 * radius {
        return Ok(sphere(radius, segments)?.with_name("capsule"));
    }
    let n = turn("capsule", segments)? / 4;
    let arc = |i: u32, side: f64| {
        let (sin, cos) = (PI / 2.0 * f64::from(i) / f64::from(n)).sin_cos();
        DVec2::new(if i == n { 0.0 } else { radius * cos }, side * (half + radius * sin))
    };
    let points = (0..=n).rev().map(|i| arc(i, -1.0)).chain((0..=n).map(|i| arc(i, 1.0))).collect();
    let mesh = revolved_mesh(&Profile::new("capsule", points, false)?, segments);
    let mass = MassProperties::of_capsule(radius, half);
    let features = SurfaceFeatures::of_rod(radius, half);
    Ok(Shape::closed_form("capsule", Capsule { radius, half }, mesh, features, mass, half + radius))
}
