//! Lemons.

use crate::shape::Shape;
use crate::shape::generate::fruit::fruit;
use base::error::Result;

/// Builds a lemon: an ellipsoid with a blunt tip at both ends; overall length and diameter in m.
///
/// # Errors
/// Fails if a parameter is out of range.
pub fn lemon(length: f64, diameter: f64, segments: u32) -> Result<Shape> {
    let profile = |s: f64| {
        let x = 2.0 * s - 1.0;
        // The body ends at 0.88 of the half length; the tips belong to a narrow ellipsoid along the full length.
        let body = (1.0 - (x / 0.88).powi(2)).max(0.0).sqrt();
        let tip = 0.22 * (1.0 - x * x).max(0.0).sqrt();
        (body.powi(4) + tip.powi(4)).powf(0.25)
    };
    fruit("lemon", length, diameter, segments, profile)
}
