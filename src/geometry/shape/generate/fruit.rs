//! Fruits: solids of revolution of a given length and diameter.

use super::revolve::revolve;
use crate::shape::Shape;
use crate::shape::params::{check_length as check, check_segments as turn};
use base::error::Result;
use glam::DVec2;

/// Builds a fruit: `profile(s)`, for s in 0..=1 along z and zero at both ends, is scaled to the given length and
/// diameter, m. The profile has `segments` segments, the number of divisions of a full turn, so that its corners are
/// too flat for a pad to detect; they are denser towards the ends, where the profile is steep.
pub(super) fn fruit(
    name: &str,
    length: f64,
    diameter: f64,
    segments: u32,
    profile: impl Fn(f64) -> f64,
) -> Result<Shape> {
    check(name, "length", length)?;
    check(name, "diameter", diameter)?;
    turn(name, segments)?;
    let largest = (0..=1000).map(|i| profile(f64::from(i) / 1000.0)).fold(f64::MIN_POSITIVE, f64::max);
    let point = |i: u32| {
        let s = 0.5 - 0.5 * (std::f64::consts::PI * f64::from(i) / f64::from(segments)).cos();
        let rho = if i == 0 || i == segments { 0.0 } else { 0.5 * diameter * profile(s) / largest };
        DVec2::new(rho, length * (s - 0.5))
    };
    revolve(name, (0..=segments).map(point).collect(), false, segments)
}
