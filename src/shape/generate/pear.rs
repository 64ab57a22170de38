//! Pears.

use crate::error::Result;
use crate::shape::Shape;
use crate::shape::generate::{fruit, revolve};
use crate::shape::params::{length as check, segments as turn};

/// A pear: a bulb at -z that narrows into a neck at +z; overall length and diameter in m.
pub fn pear(length: f64, diameter: f64, segments: u32) -> Result<Shape> {
    check("pear", "length", length)?;
    check("pear", "diameter", diameter)?;
    turn("pear", segments)?;
    let shape = |s: f64| {
        let t = ((s - 0.25) / 0.6).clamp(0.0, 1.0);
        // The neck is 0.45 of the bulb, by a cubic step.
        (s * (1.0 - s)).max(0.0).sqrt() * (1.0 - 0.55 * t * t * (3.0 - 2.0 * t))
    };
    revolve("pear", fruit(length, diameter, segments, shape), false, segments)
}
