//! Dynamic loading.

use super::defaults;
use super::leaf::{Count, NonNegative, Positive, Seconds};
use super::motion::{Motion, duration};
use serde::{Deserialize, Serialize};

/// Dynamic loading: the hand executes its motions; pads and free object have inertia.
///
/// The world frame is the object frame at the start. If the hand squeezes at any time, its fingers start where the
/// first pad touches; otherwise they stay at the gripper's `opening`. The fingers are geared: they travel equal
/// distances.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dynamic {
    /// Motions of the hand, executed one after the other.
    pub motions: Vec<Motion>,
    /// Time step, s; a step that does not converge is subdivided.
    #[serde(default = "defaults::time_step")]
    pub time_step: Seconds,
    /// Number of recorded frames: frame k of n is at the time `k / n` of the total duration of the motions, k = 1..=n.
    #[serde(default = "defaults::frames")]
    pub frames: Count<1, 10000>,
    /// Ratio of viscosity to stiffness of the gel (Kelvin-Voigt), s; zero is an elastic gel.
    #[serde(default = "defaults::damping")]
    pub damping: NonNegative,
    /// Speed at which a finger closes without contact under the largest force of the motions, m/s.
    #[serde(default = "defaults::closing_speed")]
    pub closing_speed: Positive,
}

impl Dynamic {
    /// Returns the time of each recorded frame, s.
    pub fn times(&self) -> Vec<f64> {
        let (end, n) = (duration(&self.motions), self.frames.get());
        (1..=n).map(|k| if k == n { end } else { end * k as f64 / n as f64 }).collect()
    }
}
