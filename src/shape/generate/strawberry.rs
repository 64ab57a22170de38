//! Strawberries.

use crate::error::Result;
use crate::shape::Shape;
use crate::shape::generate::{fruit, revolve};
use crate::shape::params::{length as check, segments as turn};

/// A strawberry: a rounded cone, tip at -z, shoulder at +z; overall length and diameter in m.
pub fn strawberry(length: f64, diameter: f64, segments: u32) -> Result<Shape> {
    check("strawberry", "length", length)?;
    check("strawberry", "diameter", diameter)?;
    turn("strawberry", segments)?;
    let shape = |s: f64| s.powf(0.6) * (1.0 - s).max(0.0).powf(0.3);
    revolve("strawberry", fruit(length, diameter, segments, shape), false, segments)
}
