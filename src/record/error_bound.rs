//! Error of a prediction, by the predictor's own account.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Relative errors that nine of ten predictions stay below, as the training found on grasps that it had not learnt from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorBound {
    /// Displacement, L2 over the nodes.
    pub displacement: f64,
    /// Von Mises stress, L2 over the nodes.
    pub stress: f64,
    /// Travel, mean over the fingers.
    pub travel: f64,
}

impl ErrorBound {
    /// Returns the larger of both errors, for each quantity.
    pub fn or_larger(&self, other: &Self) -> Self {
        Self {
            displacement: self.displacement.max(other.displacement),
            stress: self.stress.max(other.stress),
            travel: self.travel.max(other.travel),
        }
    }

    /// Names of the three columns.
    pub const NAMES: [&str; 3] = ["displacement_error", "stress_error", "travel_error"];

    /// Returns the numbers in the order of [`Self::NAMES`].
    pub fn to_array(self) -> [f64; 3] {
        [self.displacement, self.stress, self.travel]
    }
}

impl fmt::Display for ErrorBound {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [displacement, stress, travel] = self.to_array().map(|v| 100.0 * v);
        write!(
            f,
            "nine of ten such predictions are off by at most {displacement:.1} % in displacement, {stress:.1} % in stress, {travel:.1} % in travel"
        )
    }
}
