//! Cups.

use crate::shape::Shape;
use crate::shape::generate::revolve;
use crate::shape::params::{check_length, require};
use base::error::Result;
use glam::DVec2;

/// Builds a straight cup open at +z; outer radius, outer height, thickness of wall and floor in m.
///
/// # Errors
/// Fails if a parameter is out of range or the wall is too thick for the cup.
pub fn cup(radius: f64, height: f64, wall: f64, segments: u32) -> Result<Shape> {
    check_length("cup", "radius", radius)?;
    check_length("cup", "height", height)?;
    check_length("cup", "wall", wall)?;
    require("cup", wall <= 0.9 * radius.min(height), || {
        format!("wall {wall} m must be at most 0.9 of the radius {radius} m and of the height {height} m")
    })?;
    let h = height / 2.0;
    let r = radius - wall;
    let points = [(0.0, -h), (radius, -h), (radius, h), (r, h), (r, wall - h), (0.0, wall - h)];
    revolve("cup", points.map(DVec2::from).to_vec(), false, segments)
}
