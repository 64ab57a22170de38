//! Linear response of a pad: the displacement of all its nodes under small forces on its sensing face.
//!
//! The stiffness in the reference state is factorised once per pad, and solved for each force component. The network
//! learns the effects of large strains and of the actual pressure. The response is computed on a refined mesh, so it is
//! more accurate than that of the pad's own mesh. Displacements are over the thickness per force over `E t^2`, pad
//! frame. Bonded nodes do not move; stress is local: it follows from the displacements of the neighbours of a node.

use super::deviator::{DeviatoricStressMap, deviatoric_stress_map};
use super::refined_pad::RefinedPad;
use crate::matrix::Sparse;
use crate::matrix::numbers::F32Array;
use crate::matrix::product::{LANES, PackedMatrix, RowsView, multiply_lanes};
use base::error::{Error, Result};
use glam::DVec3;
use mech::body::cholesky::Factor;
use model::part::FingerModel;
use std::sync::Arc;

/// Number of right-hand sides that are solved at once.
const COLUMNS: usize = 96;

/// Responses to unit forces, each spread over the face around its node.
#[derive(Debug, Clone)]
pub struct Compliance {
    /// Number of nodes of the pad.
    pub nodes: usize,
    /// Number of force components: three per face node.
    pub forces: usize,
    /// Index of the first of the three rows in `response` of each movable node, over three; face nodes come first.
    pub slot: Vec<Option<u32>>,
    /// Response (movable nodes * 3, forces) of every displacement component to each force component.
    pub response: F32Array,
    /// Map from movable nodes to all nodes; rows of bonded nodes are empty.
    pub scatter: Arc<Sparse>,
    /// Map from displacements to the deviatoric stress of every node over `E`.
    pub deviator: DeviatoricStressMap,
}

impl Compliance {
    /// Computes the response of the pad of `finger` to forces on its nodes `face`; `thickness` in m. Pads of quadratic
    /// elements are refined for it.
    ///
    /// # Errors
    /// Fails if the stiffness in the reference state cannot be factorised.
    pub fn new(finger: &FingerModel, face: &[u32], thickness: f64) -> Result<Self> {
        let refined = RefinedPad::of(finger);
        let (own, turn) = (&finger.body, finger.placement.rotation);
        let body = refined.as_ref().map_or(&**own, |refined| &refined.body);
        let pattern = body.pattern();
        let (free, n) = (pattern.unknowns(), own.rest.len());
        let mut values = vec![0.0; pattern.row_idx.len()];
        body.add_stiffness(&body.rest, true, &mut vec![DVec3::ZERO; body.rest.len()], &mut values);
        let mut factor = Factor::new(body.symbolic()?, COLUMNS);
        if !factor.factorize(pattern, &values) {
            return Err(Error::Mesh(
                "the undeformed pad has no stiffness: check that some of its nodes are bonded".into(),
            ));
        }
        let place = |node: usize| pattern.position[node] as usize;
        let held = |node: usize| place(node) >= free / 3;
        let order: Vec<usize> = face.iter().map(|i| *i as usize).chain(0..n).collect();
        let (mut slot, mut moving) = (vec![None; n], Vec::new());
        for node in order {
            if !held(node) && slot[node].is_none() {
                slot[node] = Some(moving.len() as u32);
                moving.push(node);
            }
        }
        let unit = body.material.moduli().young * thickness;
        let width = 3 * moving.len();
        let mut rows = Vec::with_capacity(3 * face.len() * width);
        let around = match &refined {
            Some(refined) => refined.hat_forces(finger, face),
            None => face.iter().map(|node| vec![(*node, 1.0)]).collect(),
        };
        let axes = [turn.x_axis, turn.y_axis, turn.z_axis];
        let forces: Vec<(&Vec<(u32, f64)>, DVec3)> =
            around.iter().flat_map(|hat| axes.map(|axis| (hat, axis))).collect();
        for some in forces.chunks(COLUMNS) {
            let mut solved = vec![0.0; free * some.len()];
            for (column, (hat, axis)) in solved.chunks_exact_mut(free).zip(some) {
                for (node, part) in hat.iter().filter(|(node, _)| !held(*node as usize)) {
                    column[3 * place(*node as usize)..][..3].copy_from_slice(&(*axis * *part).to_array());
                }
            }
            factor.solve(&mut solved, some.len());
            for column in solved.chunks_exact(free) {
                let moved = moving.iter().map(|node| DVec3::from_slice(&column[3 * place(*node)..]));
                rows.extend(moved.flat_map(|u| (turn.transpose() * u * unit).to_array().map(|v| v as f32)));
            }
        }
        let mut response = vec![0.0; rows.len()];
        for (f, row) in rows.chunks_exact(width.max(1)).enumerate() {
            row.iter().enumerate().for_each(|(c, v)| response[c * forces.len() + f] = *v);
        }
        let deviator = deviatoric_stress_map(finger, &slot, thickness);
        Ok(Self::from_parts(slot, response.into(), forces.len(), deviator))
    }

    /// Creates a response from parts that were computed earlier.
    pub fn from_parts(
        slot: Vec<Option<u32>>,
        response: F32Array,
        forces: usize,
        deviator: DeviatoricStressMap,
    ) -> Self {
        let rows: Vec<Vec<(u32, f32)>> = slot.iter().map(|slot| slot.iter().map(|s| (*s, 1.0)).collect()).collect();
        let scatter = Sparse::new(&rows, response.len() / (3 * forces).max(1));
        Self { nodes: slot.len(), forces, slot, response, scatter, deviator }
    }

    /// Returns the number of displacement components: three per movable node.
    pub fn displacement_count(&self) -> usize {
        self.response.len() / self.forces.max(1)
    }

    /// Returns the response of component `a` of a node to the force components: (forces); None if the node is bonded.
    pub fn row(&self, node: u32, a: usize) -> Option<&[f32]> {
        let row = 3 * self.slot[node as usize]? as usize + a;
        Some(&self.response[row * self.forces..(row + 1) * self.forces])
    }

    /// Returns the displacements of the nodes `face` under forces on them, for each of at most [`LANES`] loads.
    pub fn face_displacements(&self, face: &[u32], loads: &[Vec<DVec3>]) -> Vec<Vec<DVec3>> {
        let mut forces = PackedMatrix::default();
        let of = |r: usize, load: usize| loads.get(load).map_or(0.0, |forces| forces[r / 3][r % 3] as f32);
        forces.fill(self.forces, LANES, of);
        // The nodes of the face come first.
        let rows = 3 * face.iter().filter(|node| self.slot[**node as usize].is_some()).count();
        let mut moved = vec![0.0; rows * LANES];
        let a = RowsView { data: &self.response, stride: self.forces, count: rows };
        multiply_lanes(a, &forces, loads.len(), &mut moved);
        let given = |node: &u32, load: usize| match self.slot[*node as usize] {
            Some(slot) => {
                DVec3::from_array([0, 1, 2].map(|c| f64::from(moved[(3 * slot as usize + c) * LANES + load])))
            }
            None => DVec3::ZERO,
        };
        (0..loads.len()).map(|load| face.iter().map(|node| given(node, load)).collect()).collect()
    }
}
