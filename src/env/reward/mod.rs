//! Rewards of an agent: one file per term; a reward is the sum of its terms.
//!
//! A new term needs settings and a variant in [`scene::reward`], a file that implements [`RewardTerm`], and a
//! line in `term`.

mod economy;
mod hold;
mod slip;
mod stress;

use scene::Reward;
use serde::{Deserialize, Serialize};

/// Information on a step, from which rewards are computed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct StepInfo {
    /// True while the object is held.
    pub held: bool,
    /// Slip of the object over the pads in this step, m.
    pub slip: f64,
    /// Accumulated slip since the start of the grasp, m.
    #[serde(rename = "slipped")]
    pub accumulated_slip: f64,
    /// Fraction of the friction limit that the load leaves unused: 0 at gross slip, 1 without load, see
    /// [`super::slip`].
    pub margin: f64,
    /// Largest nodal von Mises stress, Pa; 0 unless a reward term uses it.
    pub stress: f64,
    /// Sum of the finger forces, N.
    pub force: f64,
    /// Largest force that the agent may apply, N.
    #[serde(rename = "most")]
    pub max_force: f64,
    /// Load on the object, perpendicular to the closing direction, N.
    pub load: f64,
}

/// User-defined reward function.
pub type RewardFunction = dyn Fn(&StepInfo) -> f64 + Send + Sync;

/// Term of the reward.
pub trait RewardTerm {
    /// Returns the contribution of this term to the reward of a step.
    fn reward(&self, info: &StepInfo) -> f64;
    /// Returns true if the term uses the stress.
    fn needs_stress(&self) -> bool {
        false
    }
}

/// Returns the term as a trait object.
pub fn term(reward: &Reward) -> &dyn RewardTerm {
    match reward {
        Reward::Hold(term) => term,
        Reward::Slip(term) => term,
        Reward::Stress(term) => term,
        Reward::Economy(term) => term,
    }
}
