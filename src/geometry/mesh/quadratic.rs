//! Conversion from 4-node to 10-node tetrahedra: a node at the midpoint of every edge.

use glam::DVec3;

use crate::mesh::TetMesh;
use crate::mesh::quality::EDGES;

/// Mesh of straight-sided 10-node tetrahedra.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct QuadraticMesh {
    /// Node positions, m: first the corners in the order of the linear mesh, then one per edge in the order of
    /// [`midpoint_edges`].
    pub nodes: Vec<DVec3>,
    /// Nodes of each tetrahedron in the order of VTK and CalculiX: corners 0..3, then the midpoints of the edges (0,1),
    /// (1,2), (2,0), (0,3), (1,3), (2,3).
    pub tets: Vec<[u32; 10]>,
}

/// Returns the corner pair `[a, b]`, `a < b`, of every edge, sorted. Midpoint k of the quadratic mesh, i.e. its node
/// `corners + k`, lies between the corners of entry k, so a linear field has the mean of their values there.
pub fn midpoint_edges(mesh: &TetMesh) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> =
        mesh.tets.iter().flat_map(|tet| EDGES.map(|(a, b)| [tet[a].min(tet[b]), tet[a].max(tet[b])])).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// Adds the mid-edge nodes. Indices must be valid.
pub fn to_quadratic(mesh: &TetMesh) -> QuadraticMesh {
    let edges = midpoint_edges(mesh);
    let corners = mesh.nodes.len();
    let mut nodes = mesh.nodes.clone();
    nodes.extend(edges.iter().map(|[a, b]| 0.5 * (mesh.nodes[*a as usize] + mesh.nodes[*b as usize])));
    let tets = mesh
        .tets
        .iter()
        .map(|tet| {
            let mut ten = [0; 10];
            ten[..4].copy_from_slice(tet);
            for (slot, (a, b)) in ten[4..].iter_mut().zip(EDGES) {
                let edge = [tet[a].min(tet[b]), tet[a].max(tet[b])];
                // Every edge is in the list, which is built from the same tetrahedra.
                let k = edges.partition_point(|e| *e < edge);
                *slot = (corners + k) as u32;
            }
            ten
        })
        .collect();
    QuadraticMesh { nodes, tets }
}
