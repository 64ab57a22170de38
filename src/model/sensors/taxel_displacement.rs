//! Observation of the displacement of the sensing faces.

use super::grid::TaxelsOnFace;
use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};
use mech::potential::term::Stencil;
use scene::Grid;

/// Displacement of the sensing face at each taxel, m: (pads, rows, columns, 3), pad frame, interpolated with the shape
/// functions.
#[derive(Debug)]
pub struct TaxelDisplacement {
    shape: [usize; 4],
    samples: Vec<Stencil>,
    bounds: [f64; 2],
}

impl TaxelDisplacement {
    pub fn new(hand: &SensorSetup, grid: &Grid) -> Self {
        let samples = hand.fingers.first().map_or_else(Vec::new, |f| grid.taxel_stencils(f));
        let shape = [hand.fingers.len(), grid.rows.get(), grid.cols.get(), 3];
        Self { shape, samples, bounds: hand.displacement_bounds() }
    }
}

impl SensorModel for TaxelDisplacement {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("taxel_displacement", &self.shape, "m", self.bounds)
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        let size = 3 * self.samples.len().max(1);
        for ((pad, finger), out) in now.frame.pads.iter().zip(now.fingers).zip(out.chunks_exact_mut(size)) {
            let axes = finger.placement.rotation.transpose();
            for (out, sample) in out.chunks_exact_mut(3).zip(&self.samples) {
                out.copy_from_slice(&(axes * sample.position(&pad.displacement)).as_vec3().to_array());
            }
        }
    }
}
