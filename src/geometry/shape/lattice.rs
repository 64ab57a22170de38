//! Distances sampled on a coarse lattice: an initial guess and a lower bound for every point of a box.
//!
//! A signed distance is 1-Lipschitz, so the sample `D` at a cell's centre `c` bounds it in the cell: `d(q) >= D - |q -
//! c|`.

use crate::Aabb;
use glam::{DVec3, UVec3};

/// Approximate number of cells of a lattice: 256 kB, built in some ten milliseconds.
const CELLS: f64 = 32768.0;

/// Data of the lattice for a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LatticeCell {
    /// Lower bound of the signed distance, m.
    pub at_least: f64,
    /// Index of the facet closest to the centre of the cell.
    pub seed: u32,
}

#[derive(Debug, Clone)]
pub(crate) struct Lattice {
    min: DVec3,
    step: f64,
    counts: UVec3,
    /// Samples: (distance at the centre rounded down, m; facet).
    samples: Vec<(f32, u32)>,
}

impl Lattice {
    /// Creates an empty lattice of cubic cells over `bounds`, enlarged on every side by a tenth of its largest size.
    pub fn over(bounds: Aabb) -> Self {
        let margin = DVec3::splat(0.1 * bounds.size().max_element());
        let (min, size) = (bounds.min - margin, bounds.size() + 2.0 * margin);
        let step = (size.x * size.y * size.z / CELLS).cbrt();
        let counts = (size / step).ceil().as_uvec3();
        Self { min, step, counts, samples: Vec::new() }
    }

    /// Samples `f(centre, seed) -> (signed distance, facet)`; the seed is the facet found for the previous cell.
    pub fn fill(&mut self, f: impl Fn(DVec3, u32) -> (f64, u32)) {
        let mut samples = Vec::with_capacity(self.counts.element_product() as usize);
        let mut seed = 0;
        for z in 0..self.counts.z {
            for y in 0..self.counts.y {
                for x in 0..self.counts.x {
                    let (d, facet) = f(self.center(UVec3::new(x, y, z)), seed);
                    seed = facet;
                    samples.push(((d - 1e-6 * d.abs()) as f32, facet));
                }
            }
        }
        self.samples = samples;
    }

    fn center(&self, cell: UVec3) -> DVec3 {
        self.min + self.step * (cell.as_dvec3() + 0.5)
    }

    /// Returns the data for a point; None outside the lattice (and for a point that is not finite).
    #[inline]
    pub fn cell_at(&self, q: DVec3) -> Option<LatticeCell> {
        let at = (q - self.min) / self.step;
        if !(at.min_element() >= 0.0 && at.cmplt(self.counts.as_dvec3()).all()) {
            return None;
        }
        let cell = at.as_uvec3();
        let index = cell.x + self.counts.x * (cell.y + self.counts.y * cell.z);
        let (d, seed) = *self.samples.get(index as usize)?;
        Some(LatticeCell { at_least: f64::from(d) - self.center(cell).distance(q), seed })
    }
}
