//! Reward term for keeping the object in the hand.

use super::{RewardTerm, StepInfo};
use crate::scene::reward::HoldReward;

impl RewardTerm for HoldReward {
    fn pay(&self, facts: &StepInfo) -> f64 {
        if facts.held { self.weight.get() } else { -self.drop.get() }
    }
}
