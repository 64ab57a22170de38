//! Contact wrenches, as measured by a force-torque sensor behind each pad.

use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};

/// Wrench of each pad in the pad frame: force (N), then torque about the centre of the sensing face (N m).
#[derive(Debug)]
pub struct PadWrench {
    pads: usize,
    bounds: [f64; 2],
}

impl PadWrench {
    pub fn new(hand: &SensorSetup) -> Self {
        Self { pads: hand.fingers.len(), bounds: hand.force_bounds() }
    }
}

impl SensorModel for PadWrench {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("wrench", &[self.pads, 6], "N, N m", self.bounds)
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        for ((pad, finger), out) in now.frame.pads.iter().zip(now.fingers).zip(out.chunks_exact_mut(6)) {
            let axes = finger.placement.rotation.transpose();
            out.iter_mut().zip(pad.wrench.rotated(|v| axes * v).row()).for_each(|(o, v)| *o = v as f32);
        }
    }
}
