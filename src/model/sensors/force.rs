//! Observation of the applied force.

use super::{ArraySpec, Now, Sense, SensorSetup};

/// Applied force: sum over the fingers, N.
#[derive(Debug)]
pub struct Applied {
    most: f64,
}

impl Applied {
    pub fn new(hand: &SensorSetup) -> Self {
        Self { most: hand.force }
    }
}

impl Sense for Applied {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("force", &[1], "N", [0.0, self.most])
    }

    fn write(&self, now: &Now, out: &mut [f32]) {
        out[0] = now.frame.applied_force as f32;
    }
}
