//! Checks that a triangle mesh is a closed, oriented surface, and unambiguous repairs.

use glam::DVec3;

use crate::mesh::disjoint_sets::DisjointSets;
use crate::mesh::{TriMesh, clean};

/// Report on the edges of a triangle mesh. An edge is valid if exactly two triangles share it and traverse it in
/// opposite directions.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeReport {
    /// Edges with one triangle: the rims of holes.
    pub boundary: FaultyEdges,
    /// Edges with three or more triangles.
    pub non_manifold: FaultyEdges,
    /// Edges that both triangles traverse in the same direction.
    pub inconsistent: FaultyEdges,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of components connected through shared vertices.
    pub components: usize,
    /// Signed volume, m^3: positive if the triangles are counter-clockwise seen from outside. Only a closed mesh has
    /// a volume.
    pub signed_volume: f64,
}

/// Edges with the same fault.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FaultyEdges {
    /// Number of edges.
    pub count: usize,
    /// End points of the first edge, m.
    pub first: Option<[DVec3; 2]>,
}

impl FaultyEdges {
    fn add(&mut self, ends: [DVec3; 2]) {
        self.count += 1;
        self.first.get_or_insert(ends);
    }
}

impl EdgeReport {
    /// Returns true if the surface is closed and consistently oriented and faces outwards.
    pub fn is_solid(&self) -> bool {
        self.defect_message().is_none()
    }

    /// Returns the first fault and its remedy, in one sentence; None for a solid.
    pub fn defect_message(&self) -> Option<String> {
        let (open, crowded, twisted) = (&self.boundary, &self.non_manifold, &self.inconsistent);
        let faults = [
            (open, "is open: {} with one triangle only", "fill the holes, or weld vertices that are repeated"),
            (
                crowded,
                "is not that of a solid: {} with three or more triangles",
                "separate parts that touch along an edge",
            ),
            (twisted, "is not oriented consistently: {} whose triangles disagree", "make all normals point outward"),
        ];
        for (edges, what, cure) in faults {
            if let Some([a, b]) = edges.first {
                let number = format!("{} edge{}", edges.count, if edges.count == 1 { "" } else { "s" });
                let (what, a, b) = (what.replace("{}", &number), super::format_point(a), super::format_point(b));
                return Some(format!("the surface {what}, the first from {a} to {b}; {cure}"));
            }
        }
        if self.triangles == 0 {
            Some("the surface has no triangles".into())
        } else if self.signed_volume <= 0.0 || self.signed_volume.is_nan() {
            Some(format!("the surface encloses {:.3e} m^3: it is inside out or flat", self.signed_volume))
        } else {
            None
        }
    }
}

/// Side of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct HalfEdge {
    /// End vertices of its edge, the smaller first.
    pub ends: [u32; 2],
    /// True if the side is directed from the larger vertex to the smaller.
    pub reversed: bool,
    /// Index of the triangle.
    pub triangle: u32,
    /// Corner of the triangle at which the side starts.
    pub corner: u8,
}

/// Returns the sides of all triangles, sorted such that those of the same edge are adjacent.
pub(crate) fn half_edges(mesh: &TriMesh) -> Vec<HalfEdge> {
    let mut sides = Vec::with_capacity(3 * mesh.triangles.len());
    for (c, triangle) in mesh.triangles.iter().zip(0..) {
        for corner in 0..3_u8 {
            let (a, b) = (c[usize::from(corner)], c[(usize::from(corner) + 1) % 3]);
            sides.push(HalfEdge { ends: [a.min(b), a.max(b)], reversed: a > b, triangle, corner });
        }
    }
    sides.sort_unstable();
    sides
}

/// Examines the edges of `mesh`. Indices must be valid.
pub fn check_edges(mesh: &TriMesh) -> EdgeReport {
    let mut report = EdgeReport {
        boundary: FaultyEdges::default(),
        non_manifold: FaultyEdges::default(),
        inconsistent: FaultyEdges::default(),
        triangles: mesh.triangles.len(),
        components: components(mesh),
        signed_volume: signed_volume(mesh),
    };
    for group in half_edges(mesh).chunk_by(|x, y| x.ends == y.ends) {
        let ends = group[0].ends.map(|v| mesh.vertices[v as usize]);
        match group {
            [_] => report.boundary.add(ends),
            [one, two] if one.reversed == two.reversed => report.inconsistent.add(ends),
            [_, _] => {}
            _ => report.non_manifold.add(ends),
        }
    }
    report
}

/// Counts the components connected through shared vertices. Indices must be valid.
fn components(mesh: &TriMesh) -> usize {
    let (mut pieces, mut used) = (DisjointSets::new(mesh.vertices.len()), vec![false; mesh.vertices.len()]);
    for &[a, b, c] in &mesh.triangles {
        [a, b, c].into_iter().for_each(|i| used[i as usize] = true);
        pieces.union([a, b]);
        pieces.union([a, c]);
    }
    (0..used.len() as u32).filter(|i| used[*i as usize] && pieces.find(*i) == *i).count()
}

/// Computes the signed volume, m^3, as a sum of tetrahedra from the first vertex, which avoids cancellation for a
/// distant origin.
fn signed_volume(mesh: &TriMesh) -> f64 {
    let Some(o) = mesh.vertices.first().copied() else { return 0.0 };
    (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            (a - o).cross(b - o).dot(c - o) / 6.0
        })
        .sum()
}

/// Result of [`weld`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Welded {
    /// Number of dropped vertices: equal to an earlier one, or unused.
    pub vertices: usize,
    /// Number of dropped triangles: with a repeated vertex.
    pub triangles: usize,
}

/// Merges exactly equal vertices into the first of them, drops triangles left with a repeated vertex, then unused
/// vertices; order is kept. Indices must be valid.
pub fn weld(mesh: &mut TriMesh) -> Welded {
    let (vertices, triangles) = (mesh.vertices.len(), mesh.triangles.len());
    let first = clean::first_equal(&mesh.vertices);
    merge_vertices(mesh, &first);
    Welded { vertices: vertices - mesh.vertices.len(), triangles: triangles - mesh.triangles.len() }
}

/// Replaces each vertex `v` by vertex `first[v]`, and drops triangles left with a repeated vertex, then unused
/// vertices.
pub(crate) fn merge_vertices(mesh: &mut TriMesh, first: &[u32]) {
    for i in mesh.triangles.iter_mut().flatten() {
        *i = first[*i as usize];
    }
    mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    drop_unused(mesh);
}

/// Removes vertices that no triangle uses; returns true if there were any. Indices must be valid.
pub fn drop_unused(mesh: &mut TriMesh) -> bool {
    let mut new_index = vec![u32::MAX; mesh.vertices.len()];
    for i in mesh.triangles.iter().flatten() {
        new_index[*i as usize] = 0;
    }
    let mut kept = Vec::new();
    for (slot, p) in new_index.iter_mut().zip(&mesh.vertices) {
        if *slot == 0 {
            *slot = kept.len() as u32;
            kept.push(*p);
        }
    }
    let spare = kept.len() < mesh.vertices.len();
    for i in mesh.triangles.iter_mut().flatten() {
        *i = new_index[*i as usize];
    }
    mesh.vertices = kept;
    spare
}
