//! Spare the gel.

use super::{Facts, Pay};
use crate::scene::leaf::{NonNegative, Positive};
use serde::{Deserialize, Serialize};

/// Takes `weight` times the part by which the largest von Mises stress exceeds `limit`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stress {
    /// Pa.
    pub limit: Positive,
    /// For as much again as the limit.
    #[serde(default = "one")]
    pub weight: NonNegative,
}

const fn one() -> NonNegative {
    NonNegative::preset(1.0)
}

impl Pay for Stress {
    fn pay(&self, facts: &Facts) -> f64 {
        -self.weight.get() * (facts.stress / self.limit.get() - 1.0).max(0.0)
    }

    fn needs_stress(&self) -> bool {
        true
    }
}
