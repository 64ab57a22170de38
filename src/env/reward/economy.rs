//! Reward term for a small force: the sum of the finger forces costs.

use super::{RewardTerm, StepInfo};
use crate::scene::reward::EconomyReward;

impl RewardTerm for EconomyReward {
    fn pay(&self, info: &StepInfo) -> f64 {
        -self.weight.get() * info.force / info.most
    }
}
