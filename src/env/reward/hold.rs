//! Reward term for holding the object.

use super::{RewardTerm, StepInfo};
use scene::reward::HoldReward;

impl RewardTerm for HoldReward {
    fn reward(&self, info: &StepInfo) -> f64 {
        if info.held { self.weight.get() } else { -self.drop.get() }
    }
}
