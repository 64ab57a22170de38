//! Do not let it slide.

use super::{RewardTerm, StepInfo};
use crate::scene::reward::SlipReward;

impl RewardTerm for SlipReward {
    fn pay(&self, facts: &StepInfo) -> f64 {
        -self.weight.get() * facts.slip / 1e-3
    }
}
