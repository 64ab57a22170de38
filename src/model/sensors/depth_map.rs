//! Penetration depth of the object into the undeformed pads, the quantity of purely geometric tactile simulators.

use super::grid::TaxelsOnFace;
use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};
use geometry::height_field::PlaneGrid;
use glam::DVec3;
use rayon::prelude::*;
use scene::Grid;

/// Penetration depth of the object below the undeformed sensing face, m: (pads, rows, columns), from rays that start at
/// the back of the gel in the closing direction. The first intersection counts, so undercuts are filled. Zero where the
/// ray does not meet the object below the face; at most the depth of the gel.
#[derive(Debug)]
pub struct DepthMap {
    pads: usize,
    grid: PlaneGrid,
    /// Height of the undeformed face at the taxels, m.
    face: Vec<f64>,
    thickness: f64,
}

impl DepthMap {
    pub fn new(hand: &SensorSetup, grid: &Grid) -> Self {
        let finger = hand.fingers.first();
        let plane = finger.map_or(PlaneGrid::default(), |f| grid.taxel_grid(&f.topology));
        let at_rest = finger
            .map_or_else(Vec::new, |f| f.sensing_faces().iter().map(|face| face.positions(&f.topology.rest)).collect());
        let thickness = finger.map_or(0.0, |f| f.topology.thickness());
        Self { pads: hand.fingers.len(), grid: plane, face: plane.heights(&at_rest), thickness }
    }
}

impl SensorModel for DepthMap {
    fn spec(&self) -> ArraySpec {
        let [rows, cols] = self.grid.cells;
        ArraySpec::new("depth_map", &[self.pads, rows, cols], "m", [0.0, self.thickness])
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        let (cols, object) = (self.grid.cells[1], &now.object.distance);
        let (back, taxels) = (now.frame.object_rotation.inverse(), self.face.len().max(1));
        for ((pad, finger), out) in now.frame.pads.iter().zip(now.fingers).zip(out.chunks_exact_mut(taxels)) {
            let carried = pad.rigid_translation(&finger.body.rest);
            let along = back * finger.placement.closing;
            let depth = |k: usize| {
                let (p, reach) = (self.grid.point(k / cols, k % cols), self.face[k] + self.thickness);
                let bottom = finger.placement.place(DVec3::new(p.x, p.y, -self.thickness)) + carried;
                let bottom = back * (bottom - now.frame.object_position);
                match object.closest(bottom, reach) {
                    None => 0.0,
                    Some(closest) if closest.distance <= 0.0 => reach,
                    Some(_) => object.ray(bottom, along).map_or(0.0, |hit| (reach - hit.t).max(0.0)),
                }
            };
            out.par_iter_mut().enumerate().for_each(|(k, out)| *out = depth(k) as f32);
        }
    }
}
