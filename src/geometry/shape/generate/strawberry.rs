//! Strawberries.

use crate::shape::Shape;
use crate::shape::generate::fruit::fruit;
use base::error::Result;

/// Builds a strawberry: a rounded cone, tip at -z, shoulder at +z; overall length and diameter in m.
///
/// # Errors
/// Fails if a parameter is out of range.
pub fn strawberry(length: f64, diameter: f64, segments: u32) -> Result<Shape> {
    let profile = |s: f64| s.powf(0.6) * (1.0 - s).max(0.0).powf(0.3);
    fruit("strawberry", length, diameter, segments, profile)
}
