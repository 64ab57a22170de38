//! Shape of the deformed sensing faces: what the camera of a visual-tactile sensor looks at.

use super::{Now, Sense};
use crate::env::spec::ArraySpec;
use crate::geometry::height_field::PlaneGrid;
use crate::mech::contact::surface::SurfaceFace;
use crate::model::Model;
use crate::scene::Grid;
use glam::DVec3;

/// Height of the sensing face over the middles of the taxels, m: (pads, rows, columns), along z of the pad, by the elements' shape functions.
#[derive(Debug)]
pub struct HeightMap {
    pads: usize,
    grid: PlaneGrid,
    faces: Vec<SurfaceFace>,
    thickness: f64,
}

impl HeightMap {
    pub fn new(model: &Model, grid: &Grid) -> Self {
        let finger = model.fingers.first();
        Self {
            pads: model.fingers.len(),
            grid: finger.map_or(PlaneGrid::default(), |f| grid.over(&f.topology)),
            faces: finger.map_or_else(Vec::new, |f| f.sensing_faces()),
            thickness: finger.map_or(0.0, |f| f.topology.thickness()),
        }
    }
}

impl Sense for HeightMap {
    fn spec(&self) -> ArraySpec {
        let [rows, cols] = self.grid.cells;
        // A bonded gel does not move by more than its thickness.
        let most = 2.0 * self.thickness;
        ArraySpec::new("height_map", &[self.pads, rows, cols], "m", [-most, most])
    }

    fn write(&self, now: &Now, out: &mut [f32]) {
        let taxels: usize = self.grid.cells.iter().product();
        for ((pad, finger), out) in now.frame.pads.iter().zip(&now.model.fingers).zip(out.chunks_exact_mut(taxels)) {
            let axes = finger.placement.rotation.transpose();
            let at = |node: u32| finger.topology.rest[node as usize] + axes * pad.displacement[node as usize];
            let triangle = |face: &SurfaceFace| -> [DVec3; 6] {
                let [a, b, c] = face.corners.map(at);
                let [d, e, f] = face.mids.map_or([0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)], |mids| mids.map(at));
                [a, b, c, d, e, f]
            };
            let triangles: Vec<[DVec3; 6]> = self.faces.iter().map(triangle).collect();
            out.iter_mut().zip(self.grid.heights(&triangles)).for_each(|(out, z)| *out = z as f32);
        }
    }
}
