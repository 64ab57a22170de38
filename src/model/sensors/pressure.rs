//! Image of the pressure on the sensing faces.

use super::force_image::ForceImage;
use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};
use glam::DVec3;
use scene::Grid;

/// Normal traction on the sensing face, Pa: (pads, rows, columns). The normal is z of the pad (the closing direction),
/// not that of the deformed face, so the sum of pressure times taxel area is the closing force of the finger. Positive
/// in compression.
#[derive(Debug)]
pub struct Pressure {
    image: ForceImage,
    bounds: [f64; 2],
}

impl Pressure {
    pub fn new(hand: &SensorSetup, grid: &Grid) -> Self {
        let image = ForceImage::new(hand, grid);
        let bounds = hand.force_bounds().map(|force| force / image.taxel_area());
        Self { image, bounds }
    }
}

impl SensorModel for Pressure {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("pressure", &self.image.shape(&[]), "Pa", self.bounds)
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        let area = self.image.taxel_area();
        self.image.write(now, out, |force: DVec3| [-force.z / area]);
    }
}
