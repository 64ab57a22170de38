//! Observation of the centre of pressure.

use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};
use glam::DVec3;

/// Centre of pressure of each pad, m: (pads, 3), pad frame; the mean position of the deformed nodes, weighted by the
/// force along the closing direction. Zero, the centre of the sensing face, without contact.
#[derive(Debug)]
pub struct CenterOfPressure {
    pads: usize,
    most: f64,
}

impl CenterOfPressure {
    pub fn new(hand: &SensorSetup) -> Self {
        Self { pads: hand.fingers.len(), most: hand.reach() }
    }
}

impl SensorModel for CenterOfPressure {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("center_of_pressure", &[self.pads, 3], "m", [-self.most, self.most])
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        for ((pad, finger), out) in now.frame.pads.iter().zip(now.fingers).zip(out.chunks_exact_mut(3)) {
            let (axes, closing) = (finger.placement.rotation.transpose(), finger.placement.closing);
            let pressing = pad.contact_force.iter().map(|force| (-force.dot(closing)).max(0.0));
            let nodes = pressing.zip(&finger.topology.rest).zip(&pad.displacement).filter(|((p, _), _)| *p > 0.0);
            let (sum, whole) = nodes
                .fold((DVec3::ZERO, 0.0), |(sum, whole), ((p, rest), u)| (sum + (*rest + axes * *u) * p, whole + p));
            let center = if whole > 0.0 { sum / whole } else { DVec3::ZERO };
            out.copy_from_slice(&center.as_vec3().to_array());
        }
    }
}
