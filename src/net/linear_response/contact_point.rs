//! Contact points of a sensing face: one for each of its nodes, where the object touches the face around the node.

use glam::DVec3;

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

    /// Returns the interpolation of vectors of the face nodes.
    pub fn interpolate(&self, of_nodes: &[DVec3]) -> DVec3 {
        self.weights().map(|(node, weight)| of_nodes[node] * weight).sum()
    }
}
