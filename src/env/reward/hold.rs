//! Keep it.

use super::{Facts, Pay};
use crate::scene::reward::Hold;

impl Pay for Hold {
    fn pay(&self, facts: &Facts) -> f64 {
        if facts.held { self.weight.get() } else { -self.drop.get() }
    }
}
