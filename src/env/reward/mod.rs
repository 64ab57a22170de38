//! Rewards of an agent: one file per term; a reward is the sum of its terms.
//!
//! A new term needs settings and a variant in [`crate::scene::reward`], a file that implements [`RewardTerm`], and a line in
//! `term`.

mod economy;
mod hold;
mod slip;
mod stress;

use crate::scene::Reward;
use serde::{Deserialize, Serialize};

/// Information on a step, from which rewards are computed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct StepInfo {
    /// True while the object is in the hand.
    pub held: bool,
    /// Way of the object over the pads in this step, m.
    pub slip: f64,
    /// Way of the object over the pads since the start of the episode, m.
    pub slipped: f64,
    /// Part of the grip's limit that the load leaves: 0 is about to slip, 1 is without load, see [`super::slip`].
    pub margin: f64,
    /// Largest von Mises stress of a node, Pa; 0 if no term asks for it.
    pub stress: f64,
    /// Sum of the finger forces, N.
    pub force: f64,
    /// Largest force that the agent may ask for, N.
    pub most: f64,
    /// Load on the object across the closing direction, N.
    pub load: f64,
}

/// Reward function of the user.
pub type Custom = dyn Fn(&StepInfo) -> f64 + Send + Sync;

/// A term of the reward.
pub trait RewardTerm {
    /// Returns the payment for a step.
    fn pay(&self, info: &StepInfo) -> f64;
    /// Returns true if the term uses the stress.
    fn needs_stress(&self) -> bool {
        false
    }
}

impl Reward {
    /// Returns the term as a trait object.
    pub fn term(&self) -> &dyn RewardTerm {
        match self {
            Reward::Hold(term) => term,
            Reward::Slip(term) => term,
            Reward::Stress(term) => term,
            Reward::Economy(term) => term,
        }
    }
}
