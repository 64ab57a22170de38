//! Reward term against slip: the way of the object over the pads costs.

use super::{RewardTerm, StepInfo};
use crate::scene::reward::SlipReward;

impl RewardTerm for SlipReward {
    fn pay(&self, info: &StepInfo) -> f64 {
        -self.weight.get() * info.slip / 1e-3
    }
}
