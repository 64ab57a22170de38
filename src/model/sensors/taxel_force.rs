//! Observation of the contact force per taxel.

use super::force_image::ForceImage;
use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};
use glam::DVec3;
use scene::Grid;

/// Contact force per taxel, N: (pads, rows, columns, 3), pad frame. The sum over the taxels of a pad is its contact
/// force.
#[derive(Debug)]
pub struct TaxelForce {
    image: ForceImage,
    bounds: [f64; 2],
}

impl TaxelForce {
    pub fn new(hand: &SensorSetup, grid: &Grid) -> Self {
        Self { image: ForceImage::new(hand, grid), bounds: hand.force_bounds() }
    }
}

impl SensorModel for TaxelForce {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("taxel_force", &self.image.shape(&[3]), "N", self.bounds)
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        self.image.write(now, out, |force: DVec3| force.to_array());
    }
}
