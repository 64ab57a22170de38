//! Squeeze no harder than it takes.

use super::{Facts, Pay};
use crate::scene::leaf::NonNegative;
use serde::{Deserialize, Serialize};

/// Takes `weight` per step at the largest force, and less in proportion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Economy {
    /// Per step at the largest force.
    pub weight: NonNegative,
}

impl Default for Economy {
    fn default() -> Self {
        Self { weight: NonNegative::preset(1.0) }
    }
}

impl Pay for Economy {
    fn pay(&self, facts: &Facts) -> f64 {
        -self.weight.get() * facts.force / facts.most
    }
}
