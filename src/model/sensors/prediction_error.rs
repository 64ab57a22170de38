//! Observation of the estimated error of a prediction of the network.

use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};
use record::ErrorBound;

/// 90 % quantiles of the relative errors of predictions: displacement, stress, travel. Zero for finite elements, the
/// upper bound if unknown.
#[derive(Debug)]
pub struct PredictionError;

/// Upper bound; larger errors are clipped.
const MAX_ERROR: f64 = 10.0;

impl PredictionError {
    pub fn new(_: &SensorSetup) -> Self {
        Self
    }
}

impl SensorModel for PredictionError {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("prediction_error", &[ErrorBound::NAMES.len()], "1", [0.0, MAX_ERROR])
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        let error = now.frame.error.unwrap_or_default().to_array();
        out.iter_mut().zip(error).for_each(|(o, e)| *o = e.min(MAX_ERROR) as f32);
    }
}
