//! Contact points of a sensing face: one for each of its nodes and for each basis function of its force, where the object
//! touches the face around them.

use super::compliance::Compliance;
use super::pad_graph::PadGraph;
use glam::DVec3;
use std::borrow::Cow;

/// Covered fraction of a basis function below which it lies beside the object.
const LEAST_COVERED: f64 = 0.02;
/// Compliance of a basis function of which half is covered, beyond that of a whole one, over its own: a narrower
/// contact yields more. `a_flat_face_sinks_in_steadily_less_with_its_width`.
const UNCOVERED: f64 = 0.3;

/// Point of a sensing face between three of its nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPoint {
    /// Reference position, m, pad frame.
    pub position: DVec3,
    /// Face nodes around it, with the weights of linear interpolation; those of weight zero come last.
    pub corners: [(u32, f64); 3],
    /// Fraction of the face around the node that the object covers.
    pub covered: f64,
}

impl ContactPoint {
    /// Creates the contact point at face node `node` with this reference position.
    pub fn at_node(node: u32, position: DVec3, covered: f64) -> Self {
        Self { position, corners: [(node, 1.0), (node, 0.0), (node, 0.0)], covered }
    }

    /// Returns the face node at which it lies; None if it lies between nodes.
    pub fn node(&self) -> Option<usize> {
        (self.corners[0].1 == 1.0).then_some(self.corners[0].0 as usize)
    }

    /// Returns the corners of nonzero weight.
    pub fn weights(&self) -> impl Iterator<Item = (usize, f64)> + Clone {
        self.corners.into_iter().filter(|(_, weight)| *weight != 0.0).map(|(node, weight)| (node as usize, weight))
    }

    /// Returns the response of component `a` at this point to the force components on the face nodes with these numbers in
    /// the pad; empty if the point is at a bonded node.
    pub fn response<'a>(&self, compliance: &'a Compliance, nodes: &[u32], a: usize) -> Cow<'a, [f32]> {
        let of_node = |node: usize| compliance.row(nodes[node], a).unwrap_or_default();
        if let Some(node) = self.node() {
            return Cow::Borrowed(of_node(node));
        }
        let mut sum = vec![0.0; 3 * nodes.len()];
        for (node, weight) in self.weights() {
            sum.iter_mut().zip(of_node(node)).for_each(|(sum, c)| *sum += weight as f32 * c);
        }
        Cow::Owned(sum)
    }

    /// Returns the interpolation of vectors of the face nodes that are given by components: (face nodes * 3).
    pub fn interpolate_components(&self, of_nodes: &[f32]) -> [f32; 3] {
        if let Some(node) = self.node() {
            return [0, 1, 2].map(|k| of_nodes[3 * node + k]);
        }
        [0, 1, 2].map(|k| self.weights().map(|(node, weight)| weight as f32 * of_nodes[3 * node + k]).sum())
    }

    /// Returns the interpolation of vectors of the face nodes.
    pub fn interpolate(&self, of_nodes: &[DVec3]) -> DVec3 {
        self.weights().map(|(node, weight)| of_nodes[node] * weight).sum()
    }
}

/// Point of a basis function that touches the object.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BasisPoint {
    /// Reference position, m, pad frame.
    pub position: DVec3,
    /// Compliance of the part of the face that the object does not cover, between this point and the object.
    pub uncovered_compliance: f64,
}

impl BasisPoint {
    /// Returns those of all basis functions of a pad with these contact points of its face nodes.
    pub fn all(graph: &PadGraph, points: &[ContactPoint]) -> Vec<Self> {
        let basis = &graph.basis;
        let of = |function: usize| {
            let (weights, center) = (&basis.node_weights[function], basis.centers[function]);
            let parts =
                || weights.iter().map(|(node, weight)| (weight * points[*node as usize].covered, *node as usize));
            let covered: f64 = parts().map(|(part, _)| part).sum();
            if !(LEAST_COVERED..1.0 - 1e-9).contains(&covered) {
                return Self { position: center, uncovered_compliance: 0.0 };
            }
            let position = parts().map(|(part, node)| points[node].position * (part / covered)).sum();
            Self { position, uncovered_compliance: basis.self_compliance(function) * UNCOVERED * (1.0 / covered - 1.0) }
        };
        (0..basis.count()).map(of).collect()
    }
}
