//! Basis functions of the force on a sensing face, one around each corner node of its triangles.
//!
//! A pressure given at every node is finer than the elements below can resolve, and oscillates. A pressure that is
//! linear between corner nodes does not (mortar contact: Bernardi, Maday and Patera 1994).

use crate::linear_response::compliance::Compliance;
use glam::DVec3;
use mech::element::EDGES;
use rayon::prelude::*;
use record::{ElementNodes, PadTopology};
use std::collections::{BTreeMap, BTreeSet};

/// Additional response of a basis function to its own force, over the linear one, if its neighbours carry none: the
/// pressure within it is then not uniform. It vanishes between neighbours of equal pressure.
const LOCAL: f64 = 0.4;
/// Number of neighbours of a basis function in the interior of a triangulated face.
const NEIGHBOURS: f64 = 6.0;

/// Basis functions on a face, pad frame.
#[derive(Debug, Clone)]
pub struct MortarBasis {
    /// Weights of the face nodes in the force of a basis function; they sum to one.
    pub node_weights: Vec<Vec<(u32, f64)>>,
    /// Point of application of each force in the reference state, m.
    pub centers: Vec<DVec3>,
    /// Root mean square distance of its nodes from there, m.
    pub radius: Vec<f64>,
    /// Compliance (basis functions * 3, basis functions * 3), symmetric: mean displacement under a basis function by
    /// force components, over the thickness per `E t^2`.
    compliance: Vec<f64>,
}

impl MortarBasis {
    /// Creates the basis functions on the nodes `face` of `pad`, at positions `rest`, with the `area` of the face of
    /// each.
    pub fn new(pad: &PadTopology, face: &[u32], rest: &[DVec3], area: &[f64], response: &Compliance) -> Self {
        let own: BTreeMap<u32, u32> = face.iter().enumerate().map(|(i, n)| (*n, i as u32)).collect();
        // The two corner nodes at the ends of the edge of a midpoint node.
        let mut between = BTreeMap::new();
        if let ElementNodes::Quadratic(tets) = &pad.elements {
            for t in tets {
                between.extend((0..6).map(|k| (t[4 + k], EDGES[k].map(|corner| t[corner]))));
            }
        }
        let mut parts: BTreeMap<u32, Vec<(u32, f64)>> = BTreeMap::new();
        for (i, node) in face.iter().enumerate() {
            let corners = between.get(node).copied().unwrap_or([*node; 2]);
            for corner in corners {
                parts.entry(own.get(&corner).copied().unwrap_or(i as u32)).or_default().push((i as u32, 0.5 * area[i]));
            }
        }
        let corners: Vec<u32> = parts.keys().map(|i| face[*i as usize]).collect();
        let mut parts: Vec<_> = parts.into_values().collect();
        let sizes: Vec<f64> = parts.iter().map(|part| part.iter().map(|p| p.1).sum()).collect();
        parts.iter_mut().zip(&sizes).for_each(|(part, size)| part.iter_mut().for_each(|p| p.1 /= size));
        let n = parts.len();
        let mut compliance = vec![0.0; 9 * n * n];
        compliance.par_chunks_exact_mut(9 * n.max(1)).zip(&parts).for_each(|(own, to)| {
            for (k, own) in own.chunks_exact_mut(3 * n).enumerate() {
                // Mean displacement under the basis function per force on the nodes.
                let mut row = vec![0.0; 3 * face.len()];
                for (i, part) in to {
                    let given = response.row(face[*i as usize], k).unwrap_or_default();
                    row.iter_mut().zip(given).for_each(|(r, v)| *r += part * f64::from(*v));
                }
                for (own, from) in own.as_chunks_mut::<3>().0.iter_mut().zip(&parts) {
                    for (j, part) in from {
                        (0..3).for_each(|c| own[c] += part * row[3 * *j as usize + c]);
                    }
                }
            }
        });
        for r in 0..3 * n {
            for c in 0..r {
                let mean = 0.5 * (compliance[r * 3 * n + c] + compliance[c * 3 * n + r]);
                (compliance[r * 3 * n + c], compliance[c * 3 * n + r]) = (mean, mean);
            }
        }
        add_local(&mut compliance, &neighbours(pad, &corners), &sizes);
        let mean = |part: &Vec<(u32, f64)>| part.iter().map(|(i, w)| rest[*i as usize] * *w).sum();
        let center: Vec<DVec3> = parts.iter().map(mean).collect();
        let around = |(part, center): (&Vec<(u32, f64)>, &DVec3)| {
            part.iter().map(|(i, w)| rest[*i as usize].distance_squared(*center) * w).sum::<f64>().sqrt()
        };
        Self {
            radius: parts.iter().zip(&center).map(around).collect(),
            centers: center,
            node_weights: parts,
            compliance,
        }
    }

    /// Returns the number of basis functions.
    pub fn count(&self) -> usize {
        self.node_weights.len()
    }

    /// Returns a row of the compliance: component `k` under basis function `function`, by force components.
    pub fn row(&self, function: usize, k: usize) -> &[f64] {
        let n = 3 * self.count();
        &self.compliance[(3 * function + k) * n..][..n]
    }

    /// Returns the response of a basis function to its own force, averaged over the directions.
    pub fn self_compliance(&self, function: usize) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|k| self.row(function, k)[3 * function + k]);
        (x + y + z) / 3.0
    }

    /// Returns the mean displacement under every basis function when they press with `forces`.
    pub fn displacements(&self, forces: &[DVec3]) -> Vec<DVec3> {
        let mut moved = vec![0.0; 3 * self.count()];
        for (function, force) in forces.iter().enumerate().filter(|(_, force)| **force != DVec3::ZERO) {
            for k in 0..3 {
                // The compliance is symmetric: its rows are its columns.
                moved.iter_mut().zip(self.row(function, k)).for_each(|(u, c)| *u += c * force[k]);
            }
        }
        moved.as_chunks::<3>().0.iter().map(|u| DVec3::from_array(*u)).collect()
    }

    /// Returns the forces on the corner nodes of the elements: a force on a midpoint node is split between the ends of
    /// its edge.
    pub fn corner_forces(&self, forces: &[DVec3]) -> Vec<DVec3> {
        // Every node occurs twice in the functions around it.
        let of = |part: &Vec<(u32, f64)>| part.iter().map(|(i, _)| forces[*i as usize] * 0.5).sum();
        self.node_weights.iter().map(of).collect()
    }

    /// Returns the forces on `nodes` face nodes when the basis functions press with `forces`.
    pub fn face_forces(&self, forces: &[DVec3], nodes: usize) -> Vec<DVec3> {
        let mut out = vec![DVec3::ZERO; nodes];
        for (part, force) in self.node_weights.iter().zip(forces) {
            part.iter().for_each(|(i, w)| out[*i as usize] += *force * *w);
        }
        out
    }
}

/// Returns the pairs of basis functions, around the corner nodes `nodes`, that an edge of the surface of `pad`
/// connects.
fn neighbours(pad: &PadTopology, nodes: &[u32]) -> BTreeSet<[usize; 2]> {
    let function: BTreeMap<u32, usize> = nodes.iter().enumerate().map(|(function, node)| (*node, function)).collect();
    let edges = pad.surface.iter().flat_map(|t| [0, 1, 2].map(|k| [t[k], t[(k + 1) % 3]]));
    let pair = |[a, b]: [u32; 2]| {
        let (a, b) = (*function.get(&a)?, *function.get(&b)?);
        Some([a.min(b), a.max(b)])
    };
    edges.filter_map(pair).collect()
}

/// Adds the effect of a non-uniform pressure within basis functions to `compliance`: a spring between the pressures of
/// each pair of neighbours, whose functions have the areas `sizes`.
fn add_local(compliance: &mut [f64], pairs: &BTreeSet<[usize; 2]>, sizes: &[f64]) {
    let n = sizes.len();
    let at = |a: usize, b: usize, k: usize| (3 * a + k / 3) * 3 * n + 3 * b + k % 3;
    // Response to a unit pressure on the function alone.
    let alone: Vec<[f64; 9]> =
        (0..n).map(|a| std::array::from_fn(|k| compliance[at(a, a, k)] * sizes[a] * sizes[a])).collect();
    for [a, b] in pairs {
        for k in 0..9 {
            let spring = LOCAL / NEIGHBOURS * 0.5 * (alone[*a][k] + alone[*b][k]);
            for (p, q, sign) in [(a, a, 1.0), (b, b, 1.0), (a, b, -1.0), (b, a, -1.0)] {
                compliance[at(*p, *q, k)] += sign * spring / (sizes[*p] * sizes[*q]);
            }
        }
    }
}
