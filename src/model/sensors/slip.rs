//! Image of the slip on the sensing faces.

use super::force_image::ForceImage;
use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};
use scene::Grid;

/// Fraction of the contact force in each taxel that is carried by sliding points: (pads, rows, columns), from 0
/// (sticking, or no contact) to 1.
#[derive(Debug)]
pub struct SlipImage {
    image: ForceImage,
}

impl SlipImage {
    pub fn new(hand: &SensorSetup, grid: &Grid) -> Self {
        Self { image: ForceImage::new(hand, grid) }
    }
}

impl SensorModel for SlipImage {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("slip", &self.image.shape(&[]), "1", [0.0, 1.0])
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        for (pad, out) in now.frame.pads.iter().zip(out.chunks_exact_mut(self.image.taxels())) {
            let sizes = pad.contact_force.iter().map(|force| force.length());
            let sliding = sizes.clone().zip(&pad.slip).map(|(force, slip)| force * slip);
            let (sliding, whole) = (self.image.distribute_to_taxels(sliding), self.image.distribute_to_taxels(sizes));
            let part = |(sliding, whole): (f64, f64)| if whole > 0.0 { sliding / whole } else { 0.0 };
            out.iter_mut().zip(sliding.into_iter().zip(whole)).for_each(|(out, both)| *out = part(both) as f32);
        }
    }
}
