//! Grid of nodes, each inside or outside a surface.

use crate::Aabb;
use crate::shape::winding::Winding;
use glam::{DVec3, USizeVec3};
use rayon::prelude::*;

/// Approximate number of nodes of the grid.
const NODES: f64 = 300_000.0;

/// Grid of cubic cells around a surface.
#[derive(Debug)]
pub(crate) struct OccupancyGrid {
    origin: DVec3,
    /// Size of a cell, m.
    pub step: f64,
    /// Numbers of nodes along x, y, z.
    pub counts: USizeVec3,
    /// Flag per node, x fastest: true if the winding number is above one half. All nodes at the border of the grid are
    /// outside.
    inside: Vec<bool>,
}

impl OccupancyGrid {
    pub fn new(winding: &Winding) -> Self {
        let room = padded_bounds(winding.bvh.bounds());
        let step = (room.size().element_product() / NODES).cbrt();
        // The irregular offsets keep nodes off axis-aligned faces of the object.
        let origin = room.min - step * DVec3::new(2.37, 2.41, 2.43);
        let counts = ((room.max - origin) / step + 3.0).ceil().as_usizevec3();
        let mut field = Self { origin, step, counts, inside: Vec::new() };
        let count = counts.element_product();
        let within = |i: &usize| {
            let node = field.node(*i);
            let border = node.cmpeq(USizeVec3::ZERO).any() || node.cmpeq(counts - 1).any();
            !border && winding.at(field.position(node)) > 0.5
        };
        field.inside = (0..count).into_par_iter().map(|i| within(&i)).collect();
        field.remove_ambiguous_faces();
        field
    }

    /// Adds inside nodes until no face of a cell has exactly two inside nodes on a diagonal; the surface between inside
    /// and outside nodes is then a manifold.
    fn remove_ambiguous_faces(&mut self) {
        let mut again = true;
        while std::mem::take(&mut again) {
            for i in 0..self.inside.len() {
                let node = self.node(i);
                for k in 0..3 {
                    let (u, v) = (USizeVec3::AXES[(k + 1) % 3], USizeVec3::AXES[(k + 2) % 3]);
                    if (node + u + v).cmpge(self.counts).any() {
                        continue;
                    }
                    let face = [node, node + u, node + v, node + u + v].map(|n| self.index(n));
                    let [a, b, c, d] = face.map(|i| self.inside[i]);
                    if a == d && b == c && a != b {
                        face.iter().for_each(|i| self.inside[*i] = true);
                        again = true;
                    }
                }
            }
        }
    }

    /// Returns the index of a node.
    pub fn index(&self, node: USizeVec3) -> usize {
        node.x + self.counts.x * (node.y + self.counts.y * node.z)
    }

    fn node(&self, i: usize) -> USizeVec3 {
        let n = self.counts;
        USizeVec3::new(i % n.x, i / n.x % n.y, i / (n.x * n.y))
    }

    /// Returns true if a node is inside.
    pub fn inside(&self, node: USizeVec3) -> bool {
        self.inside[self.index(node)]
    }

    /// Returns the position of a node, m.
    pub fn position(&self, node: USizeVec3) -> DVec3 {
        self.origin + self.step * node.as_dvec3()
    }

    /// Returns the lowest node of each cell, x fastest.
    pub fn cells(&self) -> impl Iterator<Item = USizeVec3> {
        let n = self.counts - 1;
        (0..n.element_product()).map(move |i| USizeVec3::new(i % n.x, i / n.x % n.y, i / (n.x * n.y)))
    }
}

/// Returns the bounding box, enlarged such that no side is shorter than a twentieth of the longest, m.
fn padded_bounds(bounds: Aabb) -> Aabb {
    let size = bounds.size();
    let half = 0.5 * size.max(DVec3::splat(0.05 * size.max_element()));
    Aabb { min: bounds.center() - half, max: bounds.center() + half }
}
