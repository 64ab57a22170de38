//! Images of the sensing faces on a regular grid of taxels: (pads, rows, columns, 3), pad frame.

use super::{Now, Sense, force_bounds};
use crate::env::spec::ArraySpec;
use crate::model::Model;
use crate::scene::Grid;
use crate::scene::Task;
use glam::DVec3;

/// Contact force per taxel, N. The taxels of a pad sum to its contact force.
#[derive(Debug)]
pub struct ForceImage {
    pads: usize,
    grid: Grid,
    shares: Vec<[(u32, f64); 4]>,
    bounds: [f64; 2],
}

impl ForceImage {
    pub fn new(model: &Model, task: &Task, grid: &Grid) -> Self {
        let shares = model.fingers.first().map_or_else(Vec::new, |f| grid.shares(&f.topology));
        Self { pads: model.fingers.len(), grid: *grid, shares, bounds: force_bounds(task) }
    }
}

impl Sense for ForceImage {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("taxel_force", &shape(self.pads, &self.grid), "N", self.bounds)
    }

    fn write(&self, now: &Now, out: &mut [f32]) {
        let taxels = self.grid.taxels();
        let mut image = vec![DVec3::ZERO; taxels];
        for ((pad, finger), out) in now.frame.pads.iter().zip(&now.model.fingers).zip(out.chunks_exact_mut(3 * taxels))
        {
            image.fill(DVec3::ZERO);
            let touching = pad.contact_force.iter().zip(&self.shares).filter(|(f, _)| **f != DVec3::ZERO);
            for (force, shares) in touching {
                shares.iter().for_each(|(taxel, weight)| image[*taxel as usize] += *force * *weight);
            }
            let axes = finger.placement.rotation.transpose();
            put(out, image.iter().map(|f| axes * *f));
        }
    }
}

/// Displacement of the sensing face at each taxel, m.
#[derive(Debug)]
pub struct DisplacementImage {
    pads: usize,
    grid: Grid,
    samples: Vec<[(u32, f64); 3]>,
    thickness: f64,
}

impl DisplacementImage {
    pub fn new(model: &Model, _: &Task, grid: &Grid) -> Self {
        let pad = model.fingers.first().map(|f| &f.topology);
        let samples = pad.map_or_else(Vec::new, |t| grid.samples(t));
        let thickness = pad.map_or(0.0, |t| t.thickness());
        Self { pads: model.fingers.len(), grid: *grid, samples, thickness }
    }
}

impl Sense for DisplacementImage {
    fn spec(&self) -> ArraySpec {
        // A bonded gel does not move by more than its thickness.
        let most = 2.0 * self.thickness;
        ArraySpec::new("taxel_displacement", &shape(self.pads, &self.grid), "m", [-most, most])
    }

    fn write(&self, now: &Now, out: &mut [f32]) {
        let taxels = self.grid.taxels();
        for ((pad, finger), out) in now.frame.pads.iter().zip(&now.model.fingers).zip(out.chunks_exact_mut(3 * taxels))
        {
            let axes = finger.placement.rotation.transpose();
            let at =
                |nodes: &[(u32, f64); 3]| nodes.iter().map(|(n, w)| pad.displacement[*n as usize] * *w).sum::<DVec3>();
            put(out, self.samples.iter().map(|nodes| axes * at(nodes)));
        }
    }
}

fn shape(pads: usize, grid: &Grid) -> [usize; 4] {
    [pads, grid.rows.get(), grid.cols.get(), 3]
}

fn put(out: &mut [f32], vectors: impl Iterator<Item = DVec3>) {
    for (out, v) in out.chunks_exact_mut(3).zip(vectors) {
        out.copy_from_slice(&v.as_vec3().to_array());
    }
}
