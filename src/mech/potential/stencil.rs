//! Material point of a body, as an interpolation between its nodes.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A material point of a body's surface: nodes and their shape function values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Stencil {
    nodes: [u32; 6],
    phi: [f64; 6],
    len: u8,
}

impl Stencil {
    /// Stencil without nodes.
    pub const NONE: Self = Self { nodes: [0; 6], phi: [0.0; 6], len: 0 };

    /// Creates a stencil from at most six nodes and weights; weights of zero are dropped.
    pub fn new(entries: impl Iterator<Item = (u32, f64)>) -> Self {
        let mut s = Self::NONE;
        for (node, phi) in entries.filter(|(_, phi)| *phi != 0.0).take(6) {
            s.nodes[s.len as usize] = node;
            s.phi[s.len as usize] = phi;
            s.len += 1;
        }
        s
    }

    /// Nodes and shape function values.
    #[inline]
    pub fn slices(&self) -> (&[u32], &[f64]) {
        (&self.nodes[..self.len as usize], &self.phi[..self.len as usize])
    }

    /// Position of the point for node positions `x`.
    #[inline]
    pub fn position(&self, x: &[DVec3]) -> DVec3 {
        let (nodes, phi) = self.slices();
        nodes.iter().zip(phi).fold(DVec3::ZERO, |s, (&n, &p)| s + x[n as usize] * p)
    }
}
