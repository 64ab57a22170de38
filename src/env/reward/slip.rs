//! Do not let it slide.

use super::{Facts, Pay};
use crate::scene::leaf::NonNegative;
use serde::{Deserialize, Serialize};

/// Takes `weight` per millimetre that the object slides over the pads.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Slip {
    /// Per mm.
    pub weight: NonNegative,
}

impl Default for Slip {
    fn default() -> Self {
        Self { weight: NonNegative::preset(1.0) }
    }
}

impl Pay for Slip {
    fn pay(&self, facts: &Facts) -> f64 {
        -self.weight.get() * facts.slip / 1e-3
    }
}
