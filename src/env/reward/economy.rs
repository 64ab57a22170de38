//! Squeeze no harder than it takes.

use super::{Facts, Pay};
use crate::scene::reward::Economy;

impl Pay for Economy {
    fn pay(&self, facts: &Facts) -> f64 {
        -self.weight.get() * facts.force / facts.most
    }
}
