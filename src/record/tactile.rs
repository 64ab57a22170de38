//! Arrays of what a tactile sensor sees.

use serde::{Deserialize, Serialize};

/// Array of what the tactile sensors of all pads see in a frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TactileArray {
    /// Name in files, which ends in the unit if there is a single one.
    pub name: String,
    /// Unit of the numbers.
    pub unit: String,
    /// Shape, pads first, row-major.
    pub shape: Vec<usize>,
    /// Numbers.
    pub values: Vec<f32>,
}
