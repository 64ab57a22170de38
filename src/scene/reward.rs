//! What an agent may be paid for, added up.

use super::leaf::{NonNegative, Positive};
use serde::{Deserialize, Serialize};

/// One term.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Reward {
    /// For holding the object.
    Hold(HoldReward),
    /// Against slip.
    Slip(SlipReward),
    /// Against stress above a limit.
    Stress(StressReward),
    /// Against force.
    Economy(EconomyReward),
}

impl Default for Reward {
    fn default() -> Self {
        Reward::Hold(HoldReward::default())
    }
}

/// Pays `weight` per step that the object is held, takes `drop` when it is lost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[serde(rename = "Hold")]
pub struct HoldReward {
    /// Per step.
    pub weight: NonNegative,
    /// Once.
    pub drop: NonNegative,
}

impl Default for HoldReward {
    fn default() -> Self {
        Self { weight: NonNegative::preset(1.0), drop: NonNegative::preset(10.0) }
    }
}

/// Takes `weight` per millimetre that the object slides over the pads.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[serde(rename = "Slip")]
pub struct SlipReward {
    /// Per mm.
    pub weight: NonNegative,
}

impl Default for SlipReward {
    fn default() -> Self {
        Self { weight: NonNegative::preset(1.0) }
    }
}

/// Takes `weight` times the part by which the largest von Mises stress exceeds `limit`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[serde(rename = "Stress")]
pub struct StressReward {
    /// Pa.
    pub limit: Positive,
    /// For as much again as the limit.
    #[serde(default = "one")]
    pub weight: NonNegative,
}

const fn one() -> NonNegative {
    NonNegative::preset(1.0)
}

/// Takes `weight` per step at the largest force, and less in proportion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[serde(rename = "Economy")]
pub struct EconomyReward {
    /// Per step at the largest force.
    pub weight: NonNegative,
}

impl Default for EconomyReward {
    fn default() -> Self {
        Self { weight: NonNegative::preset(1.0) }
    }
}
