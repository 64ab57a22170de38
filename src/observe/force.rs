//! Observation of the closing force of the fingers.

use super::{ArraySpec, Now, Sense, SensedHand};

/// Sum of the finger forces.
#[derive(Debug)]
pub struct Applied {
    most: f64,
}

impl Applied {
    pub fn new(hand: &SensedHand) -> Self {
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
