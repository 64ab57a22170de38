//! Node lists of the elements of a body.

use glam::DVec3;

/// Node lists of the elements.
#[derive(Debug, Clone)]
pub enum Elements {
    /// 4-node tetrahedra.
    Linear(Vec<[u32; 4]>),
    /// 10-node tetrahedra: corners, then mid-edges (0,1) (1,2) (2,0) (0,3) (1,3) (2,3).
    Quadratic(Vec<[u32; 10]>),
}

impl Elements {
    /// The nodes of each element.
    pub(crate) fn lists(&self) -> Vec<&[u32]> {
        match self {
            Elements::Linear(e) => e.iter().map(|n| n.as_slice()).collect(),
            Elements::Quadratic(e) => e.iter().map(|n| n.as_slice()).collect(),
        }
    }
}

/// Positions of the nodes of one element among the positions `x`, m.
#[inline]
pub(super) fn gather<const N: usize>(nodes: &[u32; N], x: &[DVec3]) -> [DVec3; N] {
    nodes.map(|i| x[i as usize])
}
