//! Observation of the travel of the fingers.

use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};

/// Travel of each finger since first contact, left first, m.
#[derive(Debug)]
pub struct FingerTravel {
    fingers: usize,
    stroke: f64,
}

impl FingerTravel {
    pub fn new(hand: &SensorSetup) -> Self {
        Self { fingers: hand.fingers.len(), stroke: hand.stroke }
    }
}

impl SensorModel for FingerTravel {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("travel", &[self.fingers], "m", [-self.stroke, self.stroke])
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        out.iter_mut().zip(&now.frame.travel).for_each(|(o, t)| *o = *t as f32);
    }
}
