//! Image of the shear traction on the sensing faces.

use super::force_image::ForceImage;
use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};
use glam::DVec3;
use scene::Grid;

/// Tangential traction on the sensing face, Pa: (pads, rows, columns, 2), along x and y of the pad, perpendicular to
/// the closing direction.
#[derive(Debug)]
pub struct Shear {
    image: ForceImage,
    bounds: [f64; 2],
}

impl Shear {
    pub fn new(hand: &SensorSetup, grid: &Grid) -> Self {
        let image = ForceImage::new(hand, grid);
        let bounds = hand.force_bounds().map(|force| force / image.taxel_area());
        Self { image, bounds }
    }
}

impl SensorModel for Shear {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("shear", &self.image.shape(&[2]), "Pa", self.bounds)
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        let area = self.image.taxel_area();
        self.image.write(now, out, |force: DVec3| (force / area).truncate().to_array());
    }
}
