//! Keep it.

use super::{Facts, Pay};
use crate::scene::leaf::NonNegative;
use serde::{Deserialize, Serialize};

/// Pays `weight` per step that the object is held, takes `drop` when it is lost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Hold {
    /// Per step.
    pub weight: NonNegative,
    /// Once.
    pub drop: NonNegative,
}

impl Default for Hold {
    fn default() -> Self {
        Self { weight: NonNegative::preset(1.0), drop: NonNegative::preset(10.0) }
    }
}

impl Pay for Hold {
    fn pay(&self, facts: &Facts) -> f64 {
        if facts.held { self.weight.get() } else { -self.drop.get() }
    }
}
