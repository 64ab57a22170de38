//! Is a triangle mesh a closed, oriented surface? And what can be put right without guessing.

use glam::DVec3;

use crate::mesh::{TriMesh, clean};

/// What the edges of a triangle mesh say. An edge is fine if exactly two triangles share it.
#[derive(Debug, Clone, PartialEq)]
pub struct Watertight {
    /// Every edge belongs to exactly two triangles, and there is at least one.
    pub closed: bool,
    /// Wherever two triangles share an edge they run along it in opposite directions.
    pub oriented: bool,
    /// Number of edges with one triangle: the rims of holes.
    pub boundary_edges: usize,
    /// End points of the first of those, m.
    pub first_boundary: Option<[DVec3; 2]>,
    /// Number of edges with three or more triangles.
    pub non_manifold_edges: usize,
    /// End points of the first of those, m.
    pub first_non_manifold: Option<[DVec3; 2]>,
    /// Number of pieces connected through shared vertices.
    pub components: usize,
    /// Signed volume, m^3: positive if the triangles are counter-clockwise seen from outside. Only a closed mesh has
    /// a volume.
    pub signed_volume: f64,
}

impl Watertight {
    /// Closed and consistently oriented, facing outwards.
    pub fn is_solid(&self) -> bool {
        self.closed && self.oriented && self.signed_volume > 0.0
    }

    /// One sentence for a message, None for a solid.
    pub fn complaint(&self) -> Option<String> {
        let at = |edge: &Option<[DVec3; 2]>| match edge {
            Some([a, b]) => format!("the first from {} to {}", super::show(*a), super::show(*b)),
            None => String::new(),
        };
        if self.boundary_edges > 0 {
            Some(format!(
                "the surface is open: {} edges with one triangle, {}",
                self.boundary_edges,
                at(&self.first_boundary)
            ))
        } else if self.non_manifold_edges > 0 {
            let n = self.non_manifold_edges;
            Some(format!("{n} edges are shared by three or more triangles, {}", at(&self.first_non_manifold)))
        } else if !self.closed {
            Some("the surface has no triangles".into())
        } else if !self.oriented {
            Some("the triangles are not oriented consistently: neighbours disagree on which side is outside".into())
        } else if self.signed_volume <= 0.0 || self.signed_volume.is_nan() {
            Some(format!("the surface encloses {:.3e} m^3: it is inside out or flat", self.signed_volume))
        } else {
            None
        }
    }
}

/// Examines the edges of `mesh`. Indices must be valid.
pub fn watertight(mesh: &TriMesh) -> Watertight {
    let mut edges: Vec<(u32, u32, bool)> = Vec::with_capacity(3 * mesh.triangles.len());
    for [a, b, c] in &mesh.triangles {
        for (i, j) in [(*a, *b), (*b, *c), (*c, *a)] {
            edges.push((i.min(j), i.max(j), i < j));
        }
    }
    edges.sort_unstable();
    let mut report = Watertight {
        closed: !mesh.triangles.is_empty(),
        oriented: true,
        boundary_edges: 0,
        first_boundary: None,
        non_manifold_edges: 0,
        first_non_manifold: None,
        components: components(mesh),
        signed_volume: signed_volume(mesh),
    };
    for group in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let ends = [mesh.vertices[group[0].0 as usize], mesh.vertices[group[0].1 as usize]];
        match group {
            [_] => {
                report.boundary_edges += 1;
                report.first_boundary.get_or_insert(ends);
            }
            [one, two] => report.oriented &= one.2 != two.2,
            _ => {
                report.non_manifold_edges += 1;
                report.first_non_manifold.get_or_insert(ends);
            }
        }
    }
    report.closed &= report.boundary_edges == 0 && report.non_manifold_edges == 0;
    report
}

/// Number of pieces connected through shared vertices. Indices must be valid.
fn components(mesh: &TriMesh) -> usize {
    let mut parent: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    let mut used = vec![false; mesh.vertices.len()];
    for [a, b, c] in &mesh.triangles {
        for i in [a, b, c] {
            used[*i as usize] = true;
        }
        let r = root(&mut parent, *a);
        for i in [b, c] {
            let s = root(&mut parent, *i);
            parent[s as usize] = r;
        }
    }
    (0..parent.len()).filter(|i| used[*i] && parent[*i] == *i as u32).count()
}

/// Signed volume, m^3: a sum of tetrahedra from the first vertex, so that a distant origin costs no digits.
fn signed_volume(mesh: &TriMesh) -> f64 {
    let Some(o) = mesh.vertices.first().copied() else { return 0.0 };
    (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            (a - o).cross(b - o).dot(c - o) / 6.0
        })
        .sum()
}

/// Turns all triangles if the signed volume is negative; returns whether it did. Indices must be valid.
pub fn orient_outward(mesh: &mut TriMesh) -> bool {
    let inside_out = signed_volume(mesh) < 0.0;
    if inside_out {
        for triangle in &mut mesh.triangles {
            triangle.swap(1, 2);
        }
    }
    inside_out
}

/// What [`weld`] removed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Welded {
    /// Vertices that were equal to an earlier one, or unused.
    pub vertices: usize,
    /// Triangles with a repeated vertex.
    pub triangles: usize,
}

/// Merges exactly equal vertices into the first of them, drops triangles left with a repeated vertex, then unused
/// vertices; order is kept. Indices must be valid.
pub fn weld(mesh: &mut TriMesh) -> Welded {
    let (vertices, triangles) = (mesh.vertices.len(), mesh.triangles.len());
    let first = clean::first_equal(&mesh.vertices);
    for i in mesh.triangles.iter_mut().flatten() {
        *i = first[*i as usize];
    }
    mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    let mut new_index = vec![u32::MAX; vertices];
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
    for i in mesh.triangles.iter_mut().flatten() {
        *i = new_index[*i as usize];
    }
    mesh.vertices = kept;
    Welded { vertices: vertices - mesh.vertices.len(), triangles: triangles - mesh.triangles.len() }
}
