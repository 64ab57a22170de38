//! Deviatoric stress at the nodes of a pad from small displacements, as [`mech::body::Body::cauchy`] recovers
//! it.

use crate::matrix::numbers::F32Array;
use glam::DVec3;
use mech::element::{EDGES, RestTet, ShapeFunctions, TET4, TET10};
use model::part::FingerModel;
use record::ElementNodes;
use std::collections::BTreeMap;

/// Number of coefficients per neighbour: xx and yy from (x, y, z), xy from (x, y), yz from (y, z), zx from (z, x).
pub const PARTS: usize = 12;

/// Deviatoric stress of every node as a linear map of the displacements of its neighbours.
#[derive(Debug, Clone)]
pub struct DeviatoricStressMap {
    /// Start of the neighbours of each node, and their total number at the end.
    pub start: Vec<u32>,
    /// Slots of the neighbours among the movable nodes.
    pub slot: Vec<u32>,
    /// Coefficients of the neighbours: (neighbours, [`PARTS`]).
    pub parts: F32Array,
}

impl DeviatoricStressMap {
    /// Returns the slots and coefficients of the neighbours of a node.
    #[inline(always)]
    pub fn of(&self, node: usize) -> (&[u32], &[[f32; PARTS]]) {
        let own = self.start[node] as usize..self.start[node + 1] as usize;
        (&self.slot[own.clone()], &self.parts.as_chunks().0[own])
    }
}

/// Computes the deviators of the pad of `finger`: stress over `E` from displacements, over the thickness, of the nodes
/// with a slot, pad frame.
///
/// For small strains, every law of the gel reduces to Hooke's: `s = 2 mu dev(eps)`, and `2 mu / E = 1 / (1 + nu)`.
pub fn deviatoric_stress_map(finger: &FingerModel, slot: &[Option<u32>], thickness: f64) -> DeviatoricStressMap {
    let pad = &finger.topology;
    let scale = thickness / (1.0 + finger.body.material.moduli().poisson);
    let mut sums = vec![(BTreeMap::new(), 0.0); pad.rest.len()];
    match &pad.elements {
        ElementNodes::Linear(tets) => tets.iter().for_each(|t| add(&TET4, t, &pad.rest, &mut sums)),
        ElementNodes::Quadratic(tets) => tets.iter().for_each(|t| add(&TET10, t, &pad.rest, &mut sums)),
    }
    let (mut start, mut near, mut all) = (vec![0], Vec::new(), Vec::new());
    for (neighbours, volume) in &sums {
        for (j, g) in neighbours {
            if let Some(j) = slot[*j as usize] {
                near.push(j);
                all.extend(parts(*g * (scale / volume)));
            }
        }
        start.push(near.len() as u32);
    }
    DeviatoricStressMap { start, slot: near, parts: all.into() }
}

/// Adds, for every node of a tetrahedron, the gradients of the shape functions at this node times the volume.
fn add<const N: usize, const Q: usize>(
    shape: &ShapeFunctions<N, Q>,
    nodes: &[u32; N],
    rest: &[DVec3],
    sums: &mut [(BTreeMap<u32, DVec3>, f64)],
) {
    let tet = RestTet::new(std::array::from_fn(|k| rest[nodes[k] as usize]));
    let gradient = |q: usize, b: usize| (0..4).map(|k| tet.gradient[k] * shape.d[q][b][k]).sum::<DVec3>();
    for (a, node) in nodes.iter().enumerate() {
        let (near, volume) = &mut sums[*node as usize];
        let weight = extrapolation::<Q>(a);
        for (b, other) in nodes.iter().enumerate() {
            let at: DVec3 = (0..Q).map(|q| gradient(q, b) * weight[q]).sum();
            *near.entry(*other).or_insert(DVec3::ZERO) += at * tet.volume;
        }
        *volume += tet.volume;
    }
}

/// Returns the weights of the quadrature points in the value at local node `a`: linear extrapolation.
fn extrapolation<const Q: usize>(a: usize) -> [f64; Q] {
    if Q != 4 {
        return [1.0 / Q as f64; Q];
    }
    let scale = 1.0 / (TET10.points[0][0] - TET10.points[0][1]);
    let [i, j] = if a < 4 { [a, a] } else { EDGES[a - 4] };
    std::array::from_fn(|q| {
        let part = 0.5 * (f64::from(u8::from(q == i)) + f64::from(u8::from(q == j)));
        scale * part + (1.0 - scale) / Q as f64
    })
}

fn parts(g: DVec3) -> [f32; PARTS] {
    let (third, h) = (g / 3.0, g * 0.5);
    let xx = [2.0 * third.x, -third.y, -third.z];
    let yy = [-third.x, 2.0 * third.y, -third.z];
    let shear = [h.y, h.x, h.z, h.y, h.x, h.z];
    let mut all = xx.into_iter().chain(yy).chain(shear);
    std::array::from_fn(|_| all.next().unwrap_or(0.0) as f32)
}
