//! Observation of the error of a prediction, by the network's own account.

use super::{ArraySpec, Now, Sense, SensedHand};
use crate::record::ErrorBound;

/// Relative errors that nine of ten predictions stay below: displacement, stress, travel; zero for what was computed, the largest where they are
/// unknown.
#[derive(Debug)]
pub struct PredictionError;

/// Largest error that is told apart.
const MOST: f64 = 10.0;

impl PredictionError {
    pub fn new(_: &SensedHand) -> Self {
        Self
    }
}

impl Sense for PredictionError {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("prediction_error", &[ErrorBound::NAMES.len()], "1", [0.0, MOST])
    }

    fn write(&self, now: &Now, out: &mut [f32]) {
        let error = now.frame.error.unwrap_or_default().to_array();
        out.iter_mut().zip(error).for_each(|(o, e)| *o = e.min(MOST) as f32);
    }
}
