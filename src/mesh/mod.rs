//! Tetrahedral and triangle meshes: storage, surface, quality, reading and writing.

use glam::DVec3;

/// A tetrahedral mesh. Every tetrahedron has positive signed volume `(b-a) x (c-a) . (d-a) / 6`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TetMesh {
    /// Node positions, m.
    pub nodes: Vec<DVec3>,
    /// Node indices of each tetrahedron, 0-based.
    pub tets: Vec<[u32; 4]>,
}

/// A triangle mesh, counter-clockwise seen from outside.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions, m.
    pub vertices: Vec<DVec3>,
    /// Vertex indices of each triangle, 0-based.
    pub triangles: Vec<[u32; 3]>,
}
