//! Unit spheres of almost equal triangles.

use crate::mesh::TriMesh;
use glam::DVec3;
use std::collections::HashMap;

/// Builds a unit sphere from an icosahedron of which each edge is cut into `2^k` parts, so that a full turn has at
/// least `segments` (five edges of the icosahedron span about a full turn). Vertices lie on the sphere.
pub fn icosphere(segments: u32) -> TriMesh {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut vertices = Vec::new();
    // The icosahedron's vertices are the cyclic permutations of (0, +-1, +-g).
    for (s, t) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
        vertices.extend([DVec3::new(0.0, s, t * g), DVec3::new(s, t * g, 0.0), DVec3::new(t * g, 0.0, s)]);
    }
    let mut triangles = Vec::new();
    let near = |a: usize, b: usize, v: &[DVec3]| (v[a].distance_squared(v[b]) - 4.0).abs() < 1e-6;
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b, &vertices) && near(b, c, &vertices) && near(c, a, &vertices) {
                    let outward = vertices[a].dot(vertices[b].cross(vertices[c])) > 0.0;
                    triangles.push([a, if outward { b } else { c }, if outward { c } else { b }].map(|i| i as u32));
                }
            }
        }
    }
    vertices.iter_mut().for_each(|v| *v = v.normalize());
    let mut turn = 5;
    while turn < segments {
        turn *= 2;
        let mut middle = HashMap::new();
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for t in triangles {
            let m = [0, 1, 2].map(|i| {
                let (a, b) = (t[i], t[(i + 1) % 3]);
                *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                    vertices.len() as u32 - 1
                })
            });
            finer.extend([[t[0], m[0], m[2]], [t[1], m[1], m[0]], [t[2], m[2], m[1]], m]);
        }
        triangles = finer;
    }
    TriMesh { vertices, triangles }
}
