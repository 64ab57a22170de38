//! Observation of the applied force.

use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};

/// Applied force: sum over the fingers, N.
#[derive(Debug)]
pub struct AppliedForce {
    most: f64,
}

impl AppliedForce {
    pub fn new(hand: &SensorSetup) -> Self {
        Self { most: hand.force }
    }
}

impl SensorModel for AppliedForce {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("force", &[1], "N", [0.0, self.most])
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        out[0] = now.frame.applied_force as f32;
    }
}
