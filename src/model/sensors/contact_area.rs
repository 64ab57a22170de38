//! Observation of the contact area.

use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};

/// Contact area of each pad in the reference configuration, m2: (pads).
#[derive(Debug)]
pub struct TouchedArea {
    pads: usize,
    most: f64,
}

impl TouchedArea {
    pub fn new(hand: &SensorSetup) -> Self {
        let whole = |f: &crate::part::FingerModel| f.surface.area[..f.surface.vertices].iter().sum();
        Self { pads: hand.fingers.len(), most: hand.fingers.first().map_or(0.0, whole) }
    }
}

impl SensorModel for TouchedArea {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("contact_area", &[self.pads], "m2", [0.0, self.most])
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        out.iter_mut().zip(&now.frame.pads).for_each(|(out, pad)| *out = pad.contact_area as f32);
    }
}
