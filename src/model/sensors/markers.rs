//! Markers printed on the sensing faces, as tracked by the camera of a visual-tactile sensor.

use super::grid::TaxelsOnFace;
use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};
use mech::potential::term::Stencil;
use scene::Markers;

/// Markers on the sensing face: (pads, rows, columns, 8). Position and displacement, m, pad frame, interpolated with
/// the shape functions; then the image coordinates in a camera with view direction z of the pad, in pixels along x and
/// y from the image centre.
#[derive(Debug)]
pub struct MarkerTracks {
    shape: [usize; 4],
    samples: Vec<Stencil>,
    /// Size of a pixel on the face, m.
    pixel: f64,
    most: f64,
}

impl MarkerTracks {
    pub fn new(hand: &SensorSetup, markers: &Markers) -> Self {
        let (grid, pixel) = (markers.grid(), markers.pixel.get());
        let finger = hand.fingers.first();
        Self {
            shape: [hand.fingers.len(), grid.rows.get(), grid.cols.get(), 8],
            samples: finger.map_or_else(Vec::new, |f| grid.taxel_stencils(f)),
            pixel,
            most: hand.reach() / pixel.min(1.0),
        }
    }
}

impl SensorModel for MarkerTracks {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("markers", &self.shape, "m, 1", [-self.most, self.most])
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        let size = 8 * self.samples.len().max(1);
        for ((pad, finger), out) in now.frame.pads.iter().zip(now.fingers).zip(out.chunks_exact_mut(size)) {
            let axes = finger.placement.rotation.transpose();
            for (out, sample) in out.chunks_exact_mut(8).zip(&self.samples) {
                let displacement = axes * sample.position(&pad.displacement);
                let position = sample.position(&finger.topology.rest) + displacement;
                let pixels = (position / self.pixel).truncate();
                let lengths = position.to_array().into_iter().chain(displacement.to_array());
                let numbers = lengths.chain(pixels.to_array());
                out.iter_mut().zip(numbers).for_each(|(out, number)| *out = number as f32);
            }
        }
    }
}
