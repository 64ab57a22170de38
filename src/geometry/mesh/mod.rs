//! Tetrahedral and triangle meshes: storage, surface, quality, reading and writing.
//!
//! Readers are in [`io`]; the meshes that they return have valid indices and finite coordinates. [`clean::repair`]
//! repairs a tetrahedral mesh for simulation; [`topology`] checks a triangle surface. Everything is deterministic: the
//! numbering never depends on the order of a hash map.

pub mod adjacency;
pub mod clean;
pub(crate) mod disjoint_sets;
pub mod facets;
pub mod grid;
pub mod io;
pub(crate) mod polygon;
pub mod quadratic;
pub mod quality;
pub mod shells;
pub mod surface;
pub mod topology;
pub mod weld;

use glam::DVec3;

/// Tetrahedral mesh. Every tetrahedron has positive signed volume `(b-a) x (c-a) . (d-a) / 6`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TetMesh {
    /// Node positions, m.
    pub nodes: Vec<DVec3>,
    /// Node indices of each tetrahedron, 0-based.
    pub tets: Vec<[u32; 4]>,
}

/// Triangle mesh, counter-clockwise seen from outside.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriMesh {
    /// Vertex positions, m.
    pub vertices: Vec<DVec3>,
    /// Vertex indices of each triangle, 0-based.
    pub triangles: Vec<[u32; 3]>,
}

/// Largest number of nodes, vertices or elements accepted in one mesh; larger declared counts are rejected before
/// allocation.
pub const MAX_COUNT: usize = 5_000_000;

/// Largest accepted coordinate in a file, in its own unit: products of three coordinates stay far from overflow. The
/// scale in the scene converts them to metres.
pub(crate) const MAX_COORDINATE: f64 = 1e9;

impl TetMesh {
    /// Returns the corner positions of tetrahedron `t`, m. `t` must be a valid tetrahedron of a mesh with valid
    /// indices.
    pub fn corners(&self, t: usize) -> [DVec3; 4] {
        self.tets[t].map(|i| self.nodes[i as usize])
    }
}

impl TriMesh {
    /// Returns the corner positions of triangle `t`, m. `t` must be a valid triangle of a mesh with valid indices.
    pub fn corners(&self, t: usize) -> [DVec3; 3] {
        self.triangles[t].map(|i| self.vertices[i as usize])
    }
}

/// Computes the signed volume of a tetrahedron `(b-a) x (c-a) . (d-a) / 6`, m^3.
pub fn signed_volume([a, b, c, d]: [DVec3; 4]) -> f64 {
    (b - a).cross(c - a).dot(d - a) / 6.0
}

/// Returns true if a coordinate is not finite or beyond [`MAX_COORDINATE`].
pub(crate) fn is_out_of_range(p: DVec3) -> bool {
    !p.is_finite() || p.abs().max_element() > MAX_COORDINATE
}

/// Returns `p` as text for messages, in metres.
pub fn format_point(p: DVec3) -> String {
    format!("({:.6}, {:.6}, {:.6}) m", p.x, p.y, p.z)
}
