//! Do not let it slide.

use super::{Facts, Pay};
use crate::scene::reward::Slip;

impl Pay for Slip {
    fn pay(&self, facts: &Facts) -> f64 {
        -self.weight.get() * facts.slip / 1e-3
    }
}
