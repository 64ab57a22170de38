//! Regular grid of taxels on the sensing face.

use crate::part::FingerModel;
use geometry::barycentric::{barycentric, min_coordinate};
use geometry::face_lookup::FaceLookup;
use geometry::height_field::PlaneGrid;
use glam::{DVec2, DVec3};
use mech::potential::term::Stencil;
use record::PadTopology;
use scene::Grid;
use std::collections::BTreeMap;

/// Number of samples along the edge of a node triangle of mean size, for the distribution of nodal forces over the
/// taxels.
const SAMPLES: f64 = 4.0;
/// Barycentric coordinate below which a sample is outside of a triangle.
const OUTSIDE: f64 = -1e-9;

/// Taxels of a grid on the sensing face of a pad.
pub(crate) trait TaxelsOnFace {
    /// Returns the grid of taxel centres on the sensing face of `pad`, m, pad frame.
    fn taxel_grid(&self, pad: &PadTopology) -> PlaneGrid;
    /// Returns, for every node, the taxels that receive its force, with weights. They are non-negative and sum to one,
    /// so the sum over the image is the resultant. The traction is assumed linear between the nodes of the undeformed
    /// sensing face, so each taxel receives the force on its part of the face. A node without a sample assigns its
    /// force to the nearest taxel.
    fn taxel_weights(&self, pad: &PadTopology) -> Vec<Vec<(u32, f64)>>;
    /// Returns, for every taxel, the point of the sensing face at its centre as a stencil of shape functions; the
    /// nearest point of the face if the centre is outside.
    fn taxel_stencils(&self, finger: &FingerModel) -> Vec<Stencil>;
}

impl TaxelsOnFace for Grid {
    fn taxel_grid(&self, pad: &PadTopology) -> PlaneGrid {
        let face = pad.sensing.iter().flatten().map(|n| pad.rest[*n as usize].truncate());
        let (low, high) = face.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        PlaneGrid { low, size: high - low, cells: [self.rows.get(), self.cols.get()] }
    }

    fn taxel_weights(&self, pad: &PadTopology) -> Vec<Vec<(u32, f64)>> {
        let (grid, cols) = (self.taxel_grid(pad), self.cols.get());
        let flat = |n: u32| pad.rest[n as usize].truncate();
        let double = |[a, b, c]: &[u32; 3]| (flat(*b) - flat(*a)).perp_dot(flat(*c) - flat(*a)).abs();
        // The mean rather than the shortest edge, because a sliver would require millions of samples.
        let edge = (pad.sensing.iter().map(double).sum::<f64>() / pad.sensing.len() as f64).sqrt();
        let cut = (SAMPLES * grid.cell().max_element() / edge).ceil().max(1.0) as usize;
        let fine = PlaneGrid { cells: grid.cells.map(|n| n * cut), ..grid };
        let mut shares = vec![BTreeMap::new(); pad.rest.len()];
        let mut taken = vec![false; fine.cells.iter().product()];
        for nodes in &pad.sensing {
            let corners = nodes.map(flat);
            for [row, col] in fine.cells_around(&corners) {
                let weights = barycentric(fine.point(row, col), corners);
                // A sample on a shared edge belongs to one triangle only.
                if min_coordinate(weights) < OUTSIDE || std::mem::replace(&mut taken[row * fine.cells[1] + col], true) {
                    continue;
                }
                let taxel = (row / cut * cols + col / cut) as u32;
                for (node, weight) in nodes.iter().zip(weights) {
                    *shares[*node as usize].entry(taxel).or_insert(0.0) += weight.max(0.0);
                }
            }
        }
        let whole = |(own, x): (BTreeMap<u32, f64>, &DVec3)| -> Vec<(u32, f64)> {
            let sum: f64 = own.values().sum();
            if sum > 0.0 {
                return own.into_iter().map(|(taxel, weight)| (taxel, weight / sum)).collect();
            }
            let [row, col] = grid.nearest(x.truncate());
            vec![((row * cols + col) as u32, 1.0)]
        };
        shares.into_iter().zip(&pad.rest).map(whole).collect()
    }

    fn taxel_stencils(&self, finger: &FingerModel) -> Vec<Stencil> {
        let (faces, cols) = (finger.sensing_faces(), self.cols.get());
        let corners: Vec<[u32; 3]> = faces.iter().map(|face| face.corners).collect();
        let lookup = FaceLookup::new(&finger.topology.rest, &corners);
        let grid = self.taxel_grid(&finger.topology);
        let sample = |p: DVec2| lookup.locate(p).map_or(Stencil::NONE, |(face, l)| faces[face].stencil(l));
        (0..self.taxels()).map(|k| sample(grid.point(k / cols, k % cols))).collect()
    }
}
