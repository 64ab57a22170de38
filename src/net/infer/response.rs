//! Linear response of a pad, for inference: displacement of its free nodes under forces on its face, and the stress of
//! this displacement.
//!
//! Loads are interleaved, one SIMD register at a time.

use super::heads::Channels;
use crate::autodiff::ops::STRESS_REGULARISATION;
use crate::linear_response::compliance::Compliance;
use crate::linear_response::pad_graph::PadGraph;
use crate::matrix::activation::Act;
use crate::matrix::product::{PackedMatrix, Product, RowsView, padded};
use crate::network::Normalisers;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Number of nodes whose response is computed together.
const BLOCK: usize = 16;
/// Workspace of a pass.
#[derive(Debug, Default)]
pub struct ResponseWorkspace {
    forces: PackedMatrix,
    moved: Vec<f32>,
    at_nodes: Vec<f32>,
}

/// Fields that are required.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RequiredFields {
    /// Stress of all nodes; requires the interior.
    pub stress: bool,
    /// Displacement of the nodes below the sensing face; zero otherwise.
    pub interior: bool,
}

impl RequiredFields {
    /// All fields.
    pub const ALL: Self = Self { stress: true, interior: true };

    /// Returns the fields that either requires.
    pub fn or(self, other: Self) -> Self {
        Self { stress: self.stress || other.stress, interior: self.interior || other.interior }
    }
}

/// Computes the response of a pad of this graph to the contact forces of `items` (face nodes, 3: fraction of the force,
/// friction along x and y), each with its scale.
pub fn linear_response<'a>(
    graph: &'a PadGraph,
    items: &[(&[f32], f32)],
    fields: RequiredFields,
    memory: &'a mut ResponseWorkspace,
) -> LinearResponse<'a> {
    let pad = &graph.compliance;
    let (forced, items, k) = (items, items.len(), pad.forces);
    // The nodes of the face come first.
    let on_face = graph.face.iter().filter(|node| pad.slot[**node as usize].is_some()).count();
    let slots = if fields.interior { pad.displacement_count() / 3 } else { on_face };
    let stress = fields.stress;
    let wide = padded(items);
    let ResponseWorkspace { forces, moved, at_nodes } = memory;
    // From (against the closing direction, x, y) to (x, y, z) of the pad.
    let turn = [(1, 1.0), (2, 1.0), (0, -1.0)];
    forces.fill(k, items, |r, item| {
        let ((from, sign), (contact, scale)) = (turn[r % 3], forced[item]);
        sign * scale * contact[r - r % 3 + from]
    });
    moved.resize(3 * slots * wide, 0.0);
    let rows = 3 * BLOCK;
    moved.par_chunks_mut(rows * wide).zip(pad.response[..3 * slots * k].par_chunks(rows * k)).for_each(
        |(out, response)| {
            let a = RowsView { data: response, stride: k, count: out.len() / wide };
            let (act, stride) = (Act::None, wide);
            Arch::new().dispatch(Product { a, w: forces, keep: false, bias: None, act, out, stride });
        },
    );
    at_nodes.resize(pad.nodes.div_ceil(BLOCK) * BLOCK * items * 4, 0.0);
    at_nodes.par_chunks_exact_mut(BLOCK * items * 4).enumerate().for_each(|(block, out)| {
        Arch::new().dispatch(NodeBlock { pad, first: block * BLOCK, items, moved, slots, stress, out });
    });
    LinearResponse { graph, pad, items, slots, stress, at_nodes }
}

/// Counts multiplications and additions of [`linear_response`] and [`LinearResponse::correct`] for a pad under one
/// load, and the bytes of the response, which is read once per group of loads.
pub(crate) fn cost(graph: &PadGraph, stress: bool) -> (f64, f64) {
    let pad = &graph.compliance;
    let of_stress = |node: usize| if stress { 22.0 * pad.deviator.of(node).0.len() as f64 } else { 0.0 };
    let of_channels = |node: usize| 16.0 * graph.interpolate.row(node).len() as f64;
    let nodes: f64 = (0..pad.nodes).map(|node| of_stress(node) + of_channels(node)).sum();
    let response = pad.response.len() as f64;
    (2.0 * response + nodes, size_of::<f32>() as f64 * response)
}

/// Displacement and squared von Mises stress of some nodes, from the displacement of all free nodes.
struct NodeBlock<'a> {
    pad: &'a Compliance,
    first: usize,
    items: usize,
    moved: &'a [f32],
    /// Number of movable nodes whose displacement is known.
    slots: usize,
    stress: bool,
    /// Results (items, [`BLOCK`], 4).
    out: &'a mut [f32],
}

impl WithSimd for NodeBlock<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { pad, first, items, moved, slots: known, stress, out } = self;
        let wide = padded(items);
        let lanes = S::F32_LANES;
        let load = |row: usize, at: usize| S::as_simd_f32s(&moved[row * wide + at..][..lanes]).0[0];
        let mut buffer = [0.0_f32; 4 * 16];
        for node in first..(first + BLOCK).min(pad.nodes) {
            let own = pad.slot[node].filter(|slot| (*slot as usize) < known);
            if own.is_none() && !stress {
                continue;
            }
            let (slots, parts) = if stress { pad.deviator.of(node) } else { (&[][..], &[][..]) };
            for at in (0..items).step_by(lanes) {
                let mut s = [simd.splat_f32s(0.0); 5];
                for (slot, parts) in slots.iter().zip(parts) {
                    let row = 3 * *slot as usize;
                    let [x, y, z] = [load(row, at), load(row + 1, at), load(row + 2, at)];
                    let add = |sum, part: f32, u| simd.mul_add_e_f32s(simd.splat_f32s(part), u, sum);
                    s[0] = add(add(add(s[0], parts[0], x), parts[1], y), parts[2], z);
                    s[1] = add(add(add(s[1], parts[3], x), parts[4], y), parts[5], z);
                    s[2] = add(add(s[2], parts[6], x), parts[7], y);
                    s[3] = add(add(s[3], parts[8], y), parts[9], z);
                    s[4] = add(add(s[4], parts[10], z), parts[11], x);
                }
                // a2 + b2 + a b + c2 + d2 + e2
                let square = simd.mul_f32s(s[0], simd.add_f32s(s[0], s[1]));
                let square = s[1..].iter().fold(square, |sum, v| simd.mul_add_e_f32s(*v, *v, sum));
                let u =
                    own.map_or([simd.splat_f32s(0.0); 3], |slot| [0, 1, 2].map(|k| load(3 * slot as usize + k, at)));
                let rows = [u[0], u[1], u[2], simd.mul_f32s(square, simd.splat_f32s(3.0))];
                for (own, row) in buffer.chunks_exact_mut(16).zip(rows) {
                    S::as_mut_simd_f32s(&mut own[..lanes]).0[0] = row;
                }
                for lane in 0..lanes.min(items - at) {
                    let to = ((at + lane) * BLOCK + node - first) * 4;
                    for k in 0..4 {
                        out[to + k] = buffer[16 * k + lane];
                    }
                }
            }
        }
    }
}

/// Linear response of all nodes at all loads.
#[derive(Debug)]
pub struct LinearResponse<'a> {
    graph: &'a PadGraph,
    pad: &'a Compliance,
    items: usize,
    /// Number of movable nodes whose displacement is known.
    slots: usize,
    stress: bool,
    /// Values at nodes (blocks of nodes, items, [`BLOCK`], 4): displacement and squared von Mises stress.
    at_nodes: &'a [f32],
}

impl LinearResponse<'_> {
    /// Returns the response of the items from index `first` on, corrected by the network's channels of these items, in
    /// its units: displacement (items, nodes, 3) and stress (items, nodes), which is empty if not required.
    pub fn correct(&self, first: usize, heads: &Channels, norms: &Normalisers) -> (Vec<f32>, Vec<f32>) {
        let (n, items, face) = (self.pad.nodes, heads.travel.len(), self.graph.face.len());
        let stresses = if self.stress { n } else { 0 };
        let (mut displacement, mut stress) = (vec![0.0; items * n * 3], vec![0.0; items * stresses]);
        let [length, force] = [1.0 / norms.displacement, 1.0 / (norms.stress * norms.stress)];
        let mut stress_of: Vec<&mut [f32]> = stress.chunks_mut(stresses.max(1)).collect();
        stress_of.resize_with(items, Default::default);
        let each = displacement.par_chunks_exact_mut(3 * n).zip(stress_of);
        each.enumerate().for_each(|(item, (displacement, stress))| {
            let own = heads.item(item, face);
            for (node, u) in displacement.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                let moves = self.pad.slot[node].is_some_and(|slot| (slot as usize) < self.slots);
                if !moves && !self.stress {
                    continue;
                }
                let at = ((node / BLOCK * self.items + first + item) * BLOCK + node % BLOCK) * 4;
                let given = &self.at_nodes[at..at + 4];
                let (mut factor, mut more, mut beyond) = (0.0, 0.0, [0.0; 6]);
                for (channel, weight) in self.graph.interpolate.row(node) {
                    let channel = heads.channel(own, *channel as usize);
                    factor += weight * channel.stress[0];
                    more += weight * channel.stress[1];
                    beyond.iter_mut().zip(channel.displacement).for_each(|(b, v)| *b += weight * v);
                }
                if let Some(s) = stress.get_mut(node) {
                    *s = (given[3] * force + STRESS_REGULARISATION * STRESS_REGULARISATION).sqrt() * factor + more;
                }
                if moves {
                    *u = [0, 1, 2].map(|k| given[k] * length * beyond[3 + k] + beyond[k]);
                }
            }
        });
        (displacement, stress)
    }
}
