//! Contact force of the pads on a grid of taxels, the basis of force and traction images.

use super::grid::TaxelsOnFace;
use super::{SensorInput, SensorSetup};
use glam::DVec3;
use scene::Grid;
use std::ops::{AddAssign, Mul};

/// Contact force per taxel; the sum over the taxels of a pad is its contact force.
#[derive(Debug)]
pub struct ForceImage {
    pads: usize,
    grid: Grid,
    shares: Vec<Vec<(u32, f64)>>,
    /// Area of the bounding rectangle of the undeformed sensing face, m2.
    area: f64,
}

impl ForceImage {
    pub fn new(hand: &SensorSetup, grid: &Grid) -> Self {
        let pad = hand.fingers.first().map(|f| &f.topology);
        let shares = pad.map_or_else(Vec::new, |pad| grid.taxel_weights(pad));
        let area = pad.map_or(1.0, |pad| grid.taxel_grid(pad).size.element_product());
        Self { pads: hand.fingers.len(), grid: *grid, shares, area }
    }

    /// Returns the shape of the images of all pads with `components` numbers per taxel.
    pub fn shape(&self, components: &[usize]) -> Vec<usize> {
        [&[self.pads, self.grid.rows.get(), self.grid.cols.get()], components].concat()
    }

    /// Returns the area of a taxel, m2.
    pub fn taxel_area(&self) -> f64 {
        self.area / self.taxels() as f64
    }

    /// Returns the number of taxels of a pad.
    pub fn taxels(&self) -> usize {
        self.grid.taxels()
    }

    /// Distributes nodal values of a pad over the taxels; the sum is preserved.
    pub fn distribute_to_taxels<V>(&self, nodal: impl Iterator<Item = V>) -> Vec<V>
    where
        V: Copy + Default + PartialEq + AddAssign + Mul<f64, Output = V>,
    {
        let mut image = vec![V::default(); self.taxels()];
        for (value, shares) in nodal.zip(&self.shares).filter(|(value, _)| *value != V::default()) {
            shares.iter().for_each(|(taxel, weight)| image[*taxel as usize] += value * *weight);
        }
        image
    }

    /// Writes `N` numbers per taxel, computed by `numbers` from its force (N, pad frame).
    pub fn write<const N: usize>(&self, now: &SensorInput, out: &mut [f32], numbers: impl Fn(DVec3) -> [f64; N]) {
        let size = N * self.taxels();
        for ((pad, finger), out) in now.frame.pads.iter().zip(now.fingers).zip(out.chunks_exact_mut(size)) {
            let axes = finger.placement.rotation.transpose();
            let image = self.distribute_to_taxels(pad.contact_force.iter().copied());
            for (out, force) in out.chunks_exact_mut(N).zip(image) {
                out.iter_mut().zip(numbers(axes * force)).for_each(|(out, number)| *out = number as f32);
            }
        }
    }
}
