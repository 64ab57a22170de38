//! Filling of holes with triangles between the vertices of their rims.

use crate::mesh::TriMesh;
use crate::mesh::polygon::triangulate;
use crate::mesh::topology::half_edges;
use std::collections::BTreeMap;

/// Result of [`fill`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Filled {
    pub holes: usize,
    pub triangles: usize,
    /// Area of the added triangles, m2.
    pub area: f64,
}

/// Closes every hole. Each rim must be a simple loop that [`triangulate`] accepts. Returns None if a hole cannot be
/// closed or an edge has more than two triangles.
pub(crate) fn fill(mesh: &mut TriMesh) -> Option<Filled> {
    let mut after = BTreeMap::new();
    for group in half_edges(mesh).chunk_by(|x, y| x.ends == y.ends) {
        match group {
            [side] => {
                // The rim runs in the opposite direction to its only triangle.
                let [a, b] = if side.reversed { [side.ends[1], side.ends[0]] } else { side.ends };
                if after.insert(b, a).is_some() {
                    return None;
                }
            }
            [one, two] if one.reversed != two.reversed => {}
            _ => return None,
        }
    }
    let mut filled = Filled::default();
    while let Some((first, mut next)) = after.pop_first() {
        let mut rim = vec![first];
        while next != first {
            rim.push(next);
            next = after.remove(&next)?;
        }
        let points: Vec<_> = rim.iter().map(|v| mesh.vertices[*v as usize]).collect();
        let lid = triangulate(&points)?;
        filled.holes += 1;
        filled.triangles += lid.len();
        for t in lid {
            mesh.triangles.push(t.map(|i| rim[i]));
            let [a, b, c] = mesh.corners(mesh.triangles.len() - 1);
            filled.area += 0.5 * (b - a).cross(c - a).length();
        }
    }
    Some(filled)
}
