//! Bananas.

use crate::shape::Shape;
use crate::shape::generate::sweep;
use crate::shape::params::{check_length as check, check_segments as turn, require};
use base::error::Result;
use glam::DVec3;

/// Builds a banana: a tube tapered to both ends along an arc in the xz plane, midpoint at the origin, convex towards
/// +x. `length` along the arc and largest `diameter` in m; `bend` is the angle that the arc subtends, rad, 0.01 to 3.
///
/// # Errors
/// Fails if a parameter is out of range or the tube is too thick for its bend.
pub fn banana(length: f64, diameter: f64, bend: f64, segments: u32) -> Result<Shape> {
    check("banana", "length", length)?;
    check("banana", "diameter", diameter)?;
    turn("banana", segments)?;
    require("banana", (0.01..=3.0).contains(&bend), || format!("bend is {bend} rad; it must be between 0.01 and 3"))?;
    let radius = length / bend;
    require("banana", diameter <= 0.9 * radius && diameter <= length, || {
        format!(
            "diameter {diameter} m must be at most the length {length} m and 0.9 of the radius of the bend {radius} m"
        )
    })?;
    let n = segments;
    let at = |i: u32| -(std::f64::consts::PI * f64::from(i) / f64::from(n)).cos();
    let path: Vec<DVec3> = (0..=n)
        .map(|i| {
            let (sin, cos) = (0.5 * bend * at(i)).sin_cos();
            radius * DVec3::new(cos - 1.0, 0.0, sin)
        })
        .collect();
    let thickness = |i: u32| {
        if i == 0 || i == n { 0.0 } else { 0.5 * diameter * (1.0 - at(i).powi(4)).max(0.0).sqrt() }
    };
    sweep("banana", &path, &(0..=n).map(thickness).collect::<Vec<_>>(), segments)
}
