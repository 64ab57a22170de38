//! Reward term that penalises stress of the gel above a limit.

use super::{RewardTerm, StepInfo};
use scene::reward::StressReward;

impl RewardTerm for StressReward {
    fn reward(&self, info: &StepInfo) -> f64 {
        -self.weight.get() * (info.stress / self.limit.get() - 1.0).max(0.0)
    }

    fn needs_stress(&self) -> bool {
        true
    }
}
