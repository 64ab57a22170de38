//! Spare the gel.

use super::{Facts, Pay};
use crate::scene::reward::Stress;

impl Pay for Stress {
    fn pay(&self, facts: &Facts) -> f64 {
        -self.weight.get() * (facts.stress / self.limit.get() - 1.0).max(0.0)
    }

    fn needs_stress(&self) -> bool {
        true
    }
}
