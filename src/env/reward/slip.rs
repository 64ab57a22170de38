//! Reward term that penalises slip of the object over the pads.

use super::{RewardTerm, StepInfo};
use scene::reward::SlipReward;

impl RewardTerm for SlipReward {
    fn reward(&self, info: &StepInfo) -> f64 {
        -self.weight.get() * info.slip / 1e-3
    }
}
