//! Checks of the parameters of a generated shape.

use base::error::{Error, Result};

/// Default number of divisions of a full turn.
pub const DEFAULT_SEGMENTS: u32 = 64;
/// Smallest number of divisions of a full turn.
pub const MIN_SEGMENTS: u32 = 8;
/// Largest number of divisions of a full turn: meshes stay below some 300,000 triangles.
pub const MAX_SEGMENTS: u32 = 512;

/// Checks a length: between a micrometre and a hundred metres.
pub(crate) fn check_length(shape: &str, name: &str, value: f64) -> Result<f64> {
    if (1e-6..=100.0).contains(&value) {
        return Ok(value);
    }
    Err(Error::Mesh(format!("{shape}: {name} is {value} m; it must be between 1e-6 and 100 m (is it in metres?)")))
}

/// Checks a number of divisions of a full turn.
pub(crate) fn check_segments(shape: &str, value: u32) -> Result<u32> {
    if (MIN_SEGMENTS..=MAX_SEGMENTS).contains(&value) {
        return Ok(value);
    }
    Err(Error::Mesh(format!("{shape}: segments is {value}; it must be between {MIN_SEGMENTS} and {MAX_SEGMENTS}")))
}

/// Checks a relation between parameters.
pub(crate) fn require(shape: &str, holds: bool, message: impl FnOnce() -> String) -> Result<()> {
    if holds { Ok(()) } else { Err(Error::Mesh(format!("{shape}: {}", message()))) }
}
