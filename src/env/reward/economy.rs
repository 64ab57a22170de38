//! Squeeze no harder than it takes.

use super::{RewardTerm, StepInfo};
use crate::scene::reward::EconomyReward;

impl RewardTerm for EconomyReward {
    fn pay(&self, facts: &StepInfo) -> f64 {
        -self.weight.get() * facts.force / facts.most
    }
}
