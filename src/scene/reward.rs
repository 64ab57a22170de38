//! Terms of the reward of an agent, which are summed.

use super::leaf::{NonNegative, Positive};
use serde::{Deserialize, Serialize};

/// Term of the reward.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Reward {
    /// Reward for holding the object.
    Hold(HoldReward),
    /// Penalty for slip.
    Slip(SlipReward),
    /// Penalty for stress above a limit.
    Stress(StressReward),
    /// Penalty for force.
    Economy(EconomyReward),
}

impl Default for Reward {
    fn default() -> Self {
        Reward::Hold(HoldReward::default())
    }
}

/// Adds `weight` in a step in which the object is held; subtracts `drop` in a step in which it is not.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[serde(rename = "Hold")]
pub struct HoldReward {
    /// Reward per step.
    pub weight: NonNegative,
    /// Penalty of a step in which the object is not held. Without `regrasp`, such a step ends the episode, so that the
    /// penalty is applied once.
    pub drop: NonNegative,
}

impl Default for HoldReward {
    fn default() -> Self {
        Self { weight: NonNegative::new_unchecked(1.0), drop: NonNegative::new_unchecked(10.0) }
    }
}

/// Subtracts `weight` per millimetre of slip of the object on the pads.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[serde(rename = "Slip")]
pub struct SlipReward {
    /// Penalty per mm.
    pub weight: NonNegative,
}

impl Default for SlipReward {
    fn default() -> Self {
        Self { weight: NonNegative::new_unchecked(1.0) }
    }
}

/// Subtracts `weight (s / limit - 1)` if the largest von Mises stress s exceeds `limit`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[serde(rename = "Stress")]
pub struct StressReward {
    /// Limit of the stress, Pa.
    pub limit: Positive,
    /// Penalty for a stress of twice the limit.
    #[serde(default = "one")]
    pub weight: NonNegative,
}

const fn one() -> NonNegative {
    NonNegative::new_unchecked(1.0)
}

/// Subtracts `weight` times the force over the largest allowed force in each step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[serde(rename = "Economy")]
pub struct EconomyReward {
    /// Penalty per step at the largest force.
    pub weight: NonNegative,
}

impl Default for EconomyReward {
    fn default() -> Self {
        Self { weight: NonNegative::new_unchecked(1.0) }
    }
}
