//! Welding within a tolerance, for vertices separated by rounding to 32 bits or to a few decimal digits.

use std::collections::{BTreeSet, HashMap};

use glam::I64Vec3;

use crate::mesh::topology::{half_edges, merge_vertices};
use crate::mesh::{TriMesh, facets};
use base::stats::median;

/// Tolerance, over the size of the object, within which vertices at open edges are merged.
const RELATIVE_TOLERANCE: f64 = 1e-6;
/// Number of equilateral triangles of unit edge length that cover a ball of unit diameter: `4 pi / sqrt(3)`.
const TRIANGLES_PER_BALL: f64 = 7.255;

/// Result of [`weld_faulty_edges`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeWeld {
    /// Number of vertices merged into others.
    pub vertices: usize,
    /// Tolerance, m.
    pub tolerance: f64,
    /// Largest displacement of a vertex, m.
    pub moved: f64,
}

/// Returns the distance within which vertices of `mesh` may be merged, m: `1e-6 L + 2^-22 R`. The size `L`, m, is the
/// diameter of the ball covered by equilateral triangles of the number and the median edge length of the mesh; `R`, m,
/// is twice the median over the vertices of the largest coordinate magnitude. The second term is the error of two
/// roundings to 32 bits. Outlying vertices do not affect the medians.
pub fn tolerance(mesh: &TriMesh) -> f64 {
    let edges = mesh.triangles.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    let edge = median(edges.map(|ends| {
        let [p, q] = ends.map(|v| mesh.vertices[*v as usize]);
        p.distance(q)
    }));
    let size = edge * (mesh.triangles.len() as f64 / TRIANGLES_PER_BALL).sqrt();
    RELATIVE_TOLERANCE * size + 2.0 * median(mesh.vertices.iter().map(|p| p.abs().max_element())) * 2.0_f64.powi(-22)
}

/// Merges vertices at faulty edges (not shared by two triangles in opposite directions) and vertices of triangles
/// without area with the first such vertex within [`tolerance`]; drops triangles that are left with a repeated vertex.
/// A mesh without faults remains unchanged. Indices must be valid.
pub fn weld_faulty_edges(mesh: &mut TriMesh) -> Option<EdgeWeld> {
    let mut loose = BTreeSet::new();
    for group in half_edges(mesh).chunk_by(|x, y| x.ends == y.ends) {
        if !matches!(group, [one, two] if one.reversed != two.reversed) {
            loose.extend(group[0].ends);
        }
    }
    for t in 0..mesh.triangles.len() {
        if facets::is_flat(mesh.corners(t)) {
            loose.extend(mesh.triangles[t]);
        }
    }
    if loose.is_empty() {
        return None;
    }
    let tolerance = tolerance(mesh);
    let mut first: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    let mut kept: HashMap<I64Vec3, Vec<u32>> = HashMap::new();
    let (mut vertices, mut moved) = (0, 0.0_f64);
    for v in loose {
        let p = mesh.vertices[v as usize];
        let cell = (p / tolerance).floor().as_i64vec3();
        let near = |u: &&u32| mesh.vertices[**u as usize].distance(p) <= tolerance;
        let cells = (0..27_i64).map(|i| cell.saturating_add(I64Vec3::new(i % 3, i / 3 % 3, i / 9) - 1));
        match cells.filter_map(|c| kept.get(&c)?.iter().find(near)).min() {
            Some(u) => {
                first[v as usize] = *u;
                vertices += 1;
                moved = moved.max(mesh.vertices[*u as usize].distance(p));
            }
            None => kept.entry(cell).or_default().push(v),
        }
    }
    if vertices > 0 {
        merge_vertices(mesh, &first);
    }
    (vertices > 0).then_some(EdgeWeld { vertices, tolerance, moved })
}
