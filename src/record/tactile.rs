//! Arrays of tactile sensor readings.

use serde::{Deserialize, Serialize};

/// Readings of one kind of tactile sensor of all pads in a frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TactileArray {
    /// Name in files, ending in the unit if there is a single unit.
    pub name: String,
    /// Unit of the numbers.
    pub unit: String,
    /// Shape, row-major, pads first.
    pub shape: Vec<usize>,
    /// Values.
    pub values: Vec<f32>,
}
