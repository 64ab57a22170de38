//! Transfer of fields between two meshes of a pad.
//!
//! Displacement, stress and other nodal values are interpolated by the shape functions of the mesh they come from. Forces
//! on the sensing face are spread as a traction that is linear on its triangles, and its integral over small parts of these
//! triangles acts on the corners of the triangle of the other face at each part. The traction of a node is moved until its
//! centroid is the node, so that resultant force and moment are preserved, except at the rim, where parts that would lie
//! outside of the face act on the rim.

use crate::PadTopology;
use crate::error_norm::fields::Stencils;
use geometry::face_lookup::FaceLookup;
use glam::{DVec2, DVec3, Vec3Swizzles};
use std::collections::{BTreeMap, BTreeSet};
use std::iter::Sum;
use std::ops::Mul;

/// Largest number of parts of a side of a triangle.
const MOST_PARTS: usize = 6;

/// Map from nodal values on one mesh of a pad to those on another.
#[derive(Debug)]
pub struct FieldTransfer {
    nodes: Stencils,
    /// Estimated errors of interpolated values.
    errors: Stencils,
    /// Nodes of the sensing face of the target, ascending.
    face: Vec<u32>,
    bonded: Vec<bool>,
    /// Entries (node of the target, node of the source, fraction of its force), in this order.
    forces: Vec<(u32, u32, f64)>,
}

impl FieldTransfer {
    /// Creates the map from the mesh `source` to the mesh `target`.
    pub fn new(source: &PadTopology, target: &PadTopology) -> Self {
        let nodes = Stencils::new(&target.rest, source);
        Self {
            errors: nodes.error_estimate(),
            nodes,
            face: target.sensing.iter().flatten().copied().collect::<BTreeSet<u32>>().into_iter().collect(),
            bonded: target.bonded.clone(),
            forces: force_fractions(source, target),
        }
    }

    /// Returns the nodes of the source and their weights, for each node of the target.
    pub fn stencils(&self) -> &Stencils {
        &self.nodes
    }

    /// Returns the flags of the target: true if a node is bonded.
    pub fn bonded(&self) -> &[bool] {
        &self.bonded
    }

    /// Returns the nodes of the sensing face of the target.
    pub fn face(&self) -> &[u32] {
        &self.face
    }

    /// Returns the entries (node of the target, node of the source, fraction of its force).
    pub fn forces(&self) -> &[(u32, u32, f64)] {
        &self.forces
    }

    /// Returns interpolated nodal values.
    pub fn values<T: Copy + Mul<f64, Output = T> + Sum>(&self, nodal: &[T]) -> Vec<T> {
        self.nodes.of(nodal)
    }

    /// Returns estimated errors of interpolated values ([`Stencils::error_estimate`]).
    pub fn errors<T: Copy + Mul<f64, Output = T> + Sum>(&self, nodal: &[T]) -> Vec<T> {
        self.errors.of(nodal)
    }

    /// Returns the interpolated displacement, zero where the target is bonded.
    pub fn displacement(&self, nodal: &[DVec3]) -> Vec<DVec3> {
        let mut moved = self.values(nodal);
        moved.iter_mut().zip(&self.bonded).filter(|(_, bonded)| **bonded).for_each(|(u, _)| *u = DVec3::ZERO);
        moved
    }

    /// Returns the forces on the nodes of the target.
    pub fn force(&self, nodal: &[DVec3]) -> Vec<DVec3> {
        let mut out = vec![DVec3::ZERO; self.bonded.len()];
        self.forces.iter().for_each(|(to, from, part)| out[*to as usize] += nodal[*from as usize] * *part);
        out
    }
}

/// Returns the mean length of the sides of the triangles of a sensing face, m.
fn spacing(pad: &PadTopology) -> f64 {
    let side = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| pad.rest[i as usize]);
        (a.distance(b) + b.distance(c) + c.distance(a)) / 3.0
    };
    pad.sensing.iter().map(side).sum::<f64>() / pad.sensing.len().max(1) as f64
}

fn force_fractions(source: &PadTopology, target: &PadTopology) -> Vec<(u32, u32, f64)> {
    let lookup = FaceLookup::new(&target.rest, &target.sensing);
    let corners = |t: &[u32; 3]| t.map(|i| source.rest[i as usize]);
    let area = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
    let mut whole = vec![0.0; source.rest.len()];
    for t in &source.sensing {
        let third = area(corners(t)) / 3.0;
        t.iter().for_each(|i| whole[*i as usize] += third);
    }
    let ratio = spacing(source) / spacing(target).max(f64::MIN_POSITIVE);
    let parts = if ratio.is_finite() { (ratio.ceil() as usize).clamp(1, MOST_PARTS) } else { 1 };
    let centers = part_centers(parts);
    // Parts of the force of each node, with their places.
    let mut spread: Vec<Vec<(DVec2, f64)>> = vec![Vec::new(); source.rest.len()];
    for t in source.sensing.iter().filter(|t| area(corners(t)) > 0.0) {
        let (x, each) = (corners(t), area(corners(t)) / centers.len() as f64);
        for l in &centers {
            let at: DVec3 = (0..3).map(|k| x[k] * l[k]).sum();
            t.iter().zip(l).for_each(|(i, l)| spread[*i as usize].push((at.xy(), each * l / whole[*i as usize])));
        }
    }
    let mut entries: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    for (from, parts) in spread.iter().enumerate() {
        let centroid: DVec2 = parts.iter().map(|(at, force)| *at * *force).sum();
        let shift = source.rest[from].xy() - centroid;
        for (at, force) in parts {
            let Some((k, weights)) = lookup.locate(*at + shift) else { continue };
            for (to, w) in target.sensing[k].iter().zip(weights).filter(|(_, w)| *w > 0.0) {
                *entries.entry((*to, from as u32)).or_default() += force * w;
            }
        }
    }
    entries.into_iter().map(|((to, from), part)| (to, from, part)).collect()
}

/// Returns the barycentric coordinates of the centres of equal parts of a triangle whose sides are divided into `n`.
fn part_centers(n: usize) -> Vec<[f64; 3]> {
    let mut centers = Vec::with_capacity(n * n);
    for i in 0..n {
        for j in 0..n - i {
            let mut add = |third: f64| {
                let [a, b] = [i, j].map(|k| (k as f64 + third) / n as f64);
                centers.push([a, b, 1.0 - a - b]);
            };
            add(1.0 / 3.0);
            // The part that stands on its tip, between this one and the next.
            if i + j + 1 < n {
                add(2.0 / 3.0);
            }
        }
    }
    centers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ElementNodes;
    use geometry::mesh::{grid, surface};

    /// Box of 4 x 3 x 1 with its sensing face at z = 0.
    fn pad(cells: [usize; 3]) -> PadTopology {
        let line = |n: usize, from: f64, to: f64| (0..=n).map(|i| from + (to - from) * i as f64 / n as f64).collect();
        let lines: [Vec<f64>; 3] = [line(cells[0], -2.0, 2.0), line(cells[1], -1.5, 1.5), line(cells[2], -1.0, 0.0)];
        let mesh = grid::structured([&lines[0], &lines[1], &lines[2]]).unwrap();
        let faces = surface::boundary(&mesh);
        let on_top = |t: &[u32; 3]| t.iter().all(|i| mesh.nodes[*i as usize].z == 0.0);
        PadTopology {
            sensing: faces.iter().map(|f| f.nodes).filter(on_top).collect(),
            bonded: mesh.nodes.iter().map(|x| x.z == -1.0).collect(),
            corner_count: mesh.nodes.len(),
            rest: mesh.nodes,
            elements: ElementNodes::Linear(mesh.tets),
            ..PadTopology::default()
        }
    }

    #[test]
    fn forces_keep_their_sum_and_the_moment_of_a_smooth_pressure() {
        for (from, to) in [([12, 10, 3], [5, 4, 2]), ([5, 4, 2], [12, 10, 3]), ([7, 7, 2], [7, 7, 2])] {
            let (source, target) = (pad(from), pad(to));
            let mut areas = vec![0.0; source.rest.len()];
            for t in &source.sensing {
                let [a, b, c] = t.map(|i| source.rest[i as usize]);
                t.iter().for_each(|i| areas[*i as usize] += (b - a).cross(c - a).length() / 6.0);
            }
            // Zero at the rim.
            let pressure = |x: DVec2| (4.0 - x.x * x.x) * (2.25 - x.y * x.y) * (1.0 + 0.3 * x.x - 0.2 * x.y);
            let forces: Vec<DVec3> =
                source.rest.iter().zip(&areas).map(|(x, a)| DVec3::new(0.1, 0.2, -pressure(x.xy())) * *a).collect();
            let moved = FieldTransfer::new(&source, &target).force(&forces);
            let sum = |f: &[DVec3]| f.iter().sum::<DVec3>();
            assert!((sum(&moved) - sum(&forces)).length() < 1e-12 * sum(&forces).length());
            let moment =
                |pad: &PadTopology, f: &[DVec3]| pad.rest.iter().zip(f).map(|(x, f)| x.cross(*f)).sum::<DVec3>();
            let (before, after) = (moment(&source, &forces), moment(&target, &moved));
            assert!((after - before).length() < 1e-3 * sum(&forces).length(), "{before} became {after}");
        }
    }

    #[test]
    fn linear_fields_are_reproduced_and_bonded_nodes_stay() {
        let (source, target) = (pad([3, 3, 2]), pad([5, 4, 3]));
        let field = |x: DVec3| DVec3::new(x.x + 2.0 * x.y, x.z - x.y, 1.0 + x.z);
        let moved = FieldTransfer::new(&source, &target)
            .displacement(&source.rest.iter().map(|x| field(*x)).collect::<Vec<_>>());
        for ((u, x), bonded) in moved.iter().zip(&target.rest).zip(&target.bonded) {
            let wanted = if *bonded { DVec3::ZERO } else { field(*x) };
            assert!((*u - wanted).length() < 1e-12, "{u} instead of {wanted} at {x}");
        }
    }
}
