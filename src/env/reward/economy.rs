//! Reward term that penalises the sum of the finger forces.

use super::{RewardTerm, StepInfo};
use scene::reward::EconomyReward;

impl RewardTerm for EconomyReward {
    fn reward(&self, info: &StepInfo) -> f64 {
        -self.weight.get() * info.force / info.max_force
    }
}
