//! Boundary of a tetrahedral mesh: the faces that belong to one tetrahedron only.

use crate::mesh::{TetMesh, TriMesh, format_point};
use base::error::{Error, Result};

/// Faces of a tetrahedron of positive volume, counter-clockwise seen from outside; face k is opposite corner k.
pub const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Face of the boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoundaryFace {
    /// Node indices, counter-clockwise seen from outside.
    pub nodes: [u32; 3],
    /// Index of the tetrahedron to which the face belongs.
    pub tet: u32,
}

/// Returns every face as its sorted nodes, its tetrahedron and its index in that, in ascending order.
fn sorted_faces(mesh: &TetMesh) -> Vec<([u32; 3], u32, u8)> {
    let mut all = Vec::with_capacity(4 * mesh.tets.len());
    for (t, tet) in mesh.tets.iter().enumerate() {
        for (k, face) in FACES.iter().enumerate() {
            let mut key = face.map(|c| tet[c]);
            key.sort_unstable();
            all.push((key, t as u32, k as u8));
        }
    }
    all.sort_unstable();
    all
}

/// Returns the boundary faces, in the order of their tetrahedra. Indices must be valid and volumes positive, as after
/// [`crate::mesh::clean::repair`].
pub fn boundary(mesh: &TetMesh) -> Vec<BoundaryFace> {
    let mut single: Vec<(u32, u8)> = sorted_faces(mesh)
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|group| group.len() == 1)
        .map(|group| (group[0].1, group[0].2))
        .collect();
    single.sort_unstable();
    single
        .into_iter()
        .map(|(t, k)| BoundaryFace { nodes: FACES[k as usize].map(|c| mesh.tets[t as usize][c]), tet: t })
        .collect()
}

/// Returns the rim of a surface: the edges that belong to one of `triangles` only, as pairs of ascending nodes, in
/// ascending order.
pub fn rim(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let edges = triangles.iter().flat_map(|t| [0, 1, 2].map(|k| (t[k], t[(k + 1) % 3])));
    let mut edges: Vec<[u32; 2]> = edges.map(|(a, b)| [a.min(b), a.max(b)]).collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).filter(|group| group.len() == 1).map(|group| group[0]).collect()
}

/// Returns the boundary as a separate triangle mesh, with vertices in the order of the nodes, and the node of each
/// vertex. Indices must be valid.
pub fn boundary_mesh(mesh: &TetMesh) -> (TriMesh, Vec<u32>) {
    let faces = boundary(mesh);
    let mut new_index = vec![u32::MAX; mesh.nodes.len()];
    for i in faces.iter().flat_map(|f| f.nodes) {
        new_index[i as usize] = 0;
    }
    let mut surface = TriMesh::default();
    let mut node_of = Vec::new();
    for (i, slot) in new_index.iter_mut().enumerate() {
        if *slot == 0 {
            *slot = node_of.len() as u32;
            node_of.push(i as u32);
            surface.vertices.push(mesh.nodes[i]);
        }
    }
    surface.triangles = faces.iter().map(|f| f.nodes.map(|i| new_index[i as usize])).collect();
    (surface, node_of)
}

/// Rejects a face shared by three or more tetrahedra, or by two on the same side of it. Volumes must be positive.
///
/// # Errors
/// Returns [`Error::Mesh`] with the nodes, the tetrahedra and the position of the face.
pub(crate) fn check_manifold(mesh: &TetMesh) -> Result<()> {
    // The parity of the permutation from the sorted nodes to the outward order of a face determines its side.
    let even = |t: u32, k: u8| {
        let face = FACES[usize::from(k)].map(|c| mesh.tets[t as usize][c]);
        (0..3).filter(|i| face[*i] < face[(i + 1) % 3]).count() == 2
    };
    let faces = sorted_faces(mesh);
    let faulty = |group: &&[([u32; 3], u32, u8)]| match group {
        [_] => false,
        [(_, t, k), (_, u, l)] => even(*t, *k) == even(*u, *l),
        _ => true,
    };
    let Some(group) = faces.chunk_by(|a, b| a.0 == b.0).find(faulty) else { return Ok(()) };
    let corners = group[0].0.map(|i| mesh.nodes[i as usize]);
    let tets: Vec<String> = group.iter().take(6).map(|g| g.1.to_string()).collect();
    let what = if group.len() > 2 { "; at most 2 are allowed" } else { " on the same side of it" };
    Err(Error::Mesh(format!(
        "the face of nodes {:?} at {} is shared by {} tetrahedra ({}){what}: the mesh overlaps itself or contains a \
         tetrahedron twice",
        group[0].0,
        format_point(corners.iter().sum::<glam::DVec3>() / 3.0),
        group.len(),
        tets.join(", ")
    )))
}

/// Returns the index of the connected part of each tetrahedron, and the number of parts. Tetrahedra that share a face
/// belong to one part; parts are numbered in the order of their first tetrahedra. Indices must be valid.
pub(crate) fn connected_components(mesh: &TetMesh) -> (Vec<u32>, usize) {
    let faces = sorted_faces(mesh);
    let mut beside = vec![Vec::new(); mesh.tets.len()];
    for group in faces.chunk_by(|a, b| a.0 == b.0) {
        for pair in group.windows(2) {
            beside[pair[0].1 as usize].push(pair[1].1);
            beside[pair[1].1 as usize].push(pair[0].1);
        }
    }
    let (mut part, mut count) = (vec![u32::MAX; mesh.tets.len()], 0);
    for first in 0..mesh.tets.len() {
        if part[first] != u32::MAX {
            continue;
        }
        part[first] = count;
        let mut open = vec![first];
        while let Some(t) = open.pop() {
            for other in &beside[t] {
                if part[*other as usize] == u32::MAX {
                    part[*other as usize] = count;
                    open.push(*other as usize);
                }
            }
        }
        count += 1;
    }
    (part, count as usize)
}
