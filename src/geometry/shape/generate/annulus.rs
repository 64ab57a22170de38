//! Rings: hollow cylinders.

use crate::shape::Shape;
use crate::shape::generate::revolve;
use crate::shape::params::{check_length, require};
use base::error::Result;
use glam::DVec2;

/// Builds a ring of rectangular section about z; radii and height in m.
///
/// # Errors
/// Fails if a parameter is out of range or the hole is not smaller than the ring.
pub fn annulus(outer: f64, inner: f64, height: f64, segments: u32) -> Result<Shape> {
    check_length("annulus", "outer_radius", outer)?;
    check_length("annulus", "inner_radius", inner)?;
    check_length("annulus", "height", height)?;
    require("annulus", inner <= 0.999 * outer, || {
        format!("inner_radius {inner} m must be less than 0.999 of outer_radius {outer} m")
    })?;
    let h = height / 2.0;
    let points = [(inner, -h), (outer, -h), (outer, h), (inner, h)].map(DVec2::from);
    revolve("annulus", points.to_vec(), true, segments)
}
