//! Pears.

use crate::shape::Shape;
use crate::shape::generate::fruit::fruit;
use base::error::Result;

/// Builds a pear: a bulb at -z that narrows into a neck at +z; overall length and diameter in m.
///
/// # Errors
/// Fails if a parameter is out of range.
pub fn pear(length: f64, diameter: f64, segments: u32) -> Result<Shape> {
    let profile = |s: f64| {
        let t = ((s - 0.25) / 0.6).clamp(0.0, 1.0);
        // The neck is 0.45 of the bulb, by a cubic step.
        (s * (1.0 - s)).max(0.0).sqrt() * (1.0 - 0.55 * t * t * (3.0 - 2.0 * t))
    };
    fruit("pear", length, diameter, segments, profile)
}
