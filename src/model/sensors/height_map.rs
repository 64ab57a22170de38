//! Shape of the deformed sensing faces, as a visual-tactile sensor images it.

use super::grid::TaxelsOnFace;
use super::{ArraySpec, SensorInput, SensorModel, SensorSetup};
use geometry::height_field::PlaneGrid;
use glam::DVec3;
use mech::contact::surface::SurfaceFace;
use scene::Grid;

/// Height of the sensing face at the taxel centres, m: (pads, rows, columns), along z of the pad, interpolated with the
/// shape functions.
#[derive(Debug)]
pub struct HeightMap {
    pads: usize,
    grid: PlaneGrid,
    faces: Vec<SurfaceFace>,
    bounds: [f64; 2],
}

impl HeightMap {
    pub fn new(hand: &SensorSetup, grid: &Grid) -> Self {
        let finger = hand.fingers.first();
        Self {
            pads: hand.fingers.len(),
            grid: finger.map_or(PlaneGrid::default(), |f| grid.taxel_grid(&f.topology)),
            faces: finger.map_or_else(Vec::new, |f| f.sensing_faces()),
            bounds: hand.displacement_bounds(),
        }
    }
}

impl SensorModel for HeightMap {
    fn spec(&self) -> ArraySpec {
        let [rows, cols] = self.grid.cells;
        ArraySpec::new("height_map", &[self.pads, rows, cols], "m", self.bounds)
    }

    fn write(&self, now: &SensorInput, out: &mut [f32]) {
        let taxels: usize = self.grid.cells.iter().product();
        for ((pad, finger), out) in now.frame.pads.iter().zip(now.fingers).zip(out.chunks_exact_mut(taxels)) {
            let axes = finger.placement.rotation.transpose();
            let moved = finger.topology.rest.iter().zip(&pad.displacement).map(|(rest, u)| *rest + axes * *u);
            let x: Vec<DVec3> = moved.collect();
            let triangles: Vec<[DVec3; 6]> = self.faces.iter().map(|face| face.positions(&x)).collect();
            out.iter_mut().zip(self.grid.heights(&triangles)).for_each(|(out, z)| *out = z as f32);
        }
    }
}
