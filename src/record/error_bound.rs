//! Estimated error of a prediction of the network.

use serde::{Deserialize, Serialize};
use std::fmt;

/// 90 % quantiles of the relative errors of predictions, measured during training on held-out grasps; infinite, and
/// null in JSON, if unknown.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorBound {
    /// Displacement, L2 over the nodes.
    #[serde(with = "bound")]
    pub displacement: f64,
    /// Von Mises stress, L2 over the nodes.
    #[serde(with = "bound")]
    pub stress: f64,
    /// Travel, mean over the fingers.
    #[serde(with = "bound")]
    pub travel: f64,
}

/// Serialisation of a bound as an optional number, because JSON has no infinity.
mod bound {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(bound: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        Some(*bound).filter(|bound| bound.is_finite()).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
    }
}

impl ErrorBound {
    /// Unknown errors: all bounds are infinite.
    pub const UNKNOWN: Self = Self { displacement: f64::INFINITY, stress: f64::INFINITY, travel: f64::INFINITY };

    /// Returns true if all bounds are finite.
    pub fn is_known(&self) -> bool {
        self.to_array().iter().all(|bound| bound.is_finite())
    }

    /// Returns the elementwise maximum.
    pub fn or_larger(&self, other: &Self) -> Self {
        Self {
            displacement: self.displacement.max(other.displacement),
            stress: self.stress.max(other.stress),
            travel: self.travel.max(other.travel),
        }
    }

    /// Column names of the three bounds.
    pub const NAMES: [&str; 3] = ["displacement_error", "stress_error", "travel_error"];

    /// Returns the bounds in the order of [`Self::NAMES`].
    pub fn to_array(self) -> [f64; 3] {
        [self.displacement, self.stress, self.travel]
    }
}

impl fmt::Display for ErrorBound {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if !self.is_known() {
            return f.write_str("the error of such predictions is unknown");
        }
        let [displacement, stress, travel] = self.to_array().map(|v| 100.0 * v);
        write!(
            f,
            "errors of nine of ten such predictions are at most {displacement:.1} % in displacement, {stress:.1} % in \
             stress, {travel:.1} % in travel"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_error_is_null_in_json_and_unknown_in_words() {
        let known = ErrorBound { displacement: 0.1, stress: 0.2, travel: 0.3 };
        for (bound, json) in [(known, "0.1"), (ErrorBound::UNKNOWN, "null")] {
            let text = serde_json::to_string(&bound).unwrap();
            assert!(text.contains(&format!("\"displacement\":{json}")), "{text}");
            assert_eq!(serde_json::from_str::<ErrorBound>(&text).unwrap(), bound);
            assert_eq!(postcard::from_bytes::<ErrorBound>(&postcard::to_stdvec(&bound).unwrap()).unwrap(), bound);
        }
        assert!(ErrorBound::UNKNOWN.to_string().contains("unknown"));
        assert_eq!(known.or_larger(&ErrorBound::UNKNOWN), ErrorBound::UNKNOWN);
    }
}
