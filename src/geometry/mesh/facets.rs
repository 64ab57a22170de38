//! Removal of redundant triangles: repeated triangles and triangles without area.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use crate::mesh::TriMesh;
use crate::mesh::topology::{drop_unused, half_edges};

/// Ratio of height to longest side up to which a triangle counts as one without area.
pub(crate) const FLAT_RATIO: f64 = 1e-13;

/// Returns true if the triangle is too thin to have a normal.
pub(crate) fn is_flat(p: [DVec3; 3]) -> bool {
    let longest = (0..3).map(|i| p[i].distance_squared(p[(i + 1) % 3])).fold(0.0, f64::max);
    let twice_area = (p[1] - p[0]).cross(p[2] - p[0]).length();
    twice_area.is_nan() || twice_area <= FLAT_RATIO * longest
}

/// Drops triangles with the same corners and orientation as an earlier one; returns their number. Indices must be
/// valid.
pub fn drop_repeated(mesh: &mut TriMesh) -> usize {
    let before = mesh.triangles.len();
    let mut seen = BTreeSet::new();
    mesh.triangles.retain(|t| {
        let least = (0..3).fold(0, |i, k| if t[k] < t[i] { k } else { i });
        seen.insert([t[least], t[(least + 1) % 3], t[(least + 2) % 3]])
    });
    before - mesh.triangles.len()
}

/// Drops pairs of triangles with the same corners and opposite orientation, which enclose no volume: the common face of
/// parts that touch, or a sheet. Returns the number of pairs. Indices must be valid.
pub fn drop_back_to_back(mesh: &mut TriMesh) -> usize {
    let sorted = |t: &[u32; 3]| {
        let mut corners = *t;
        corners.sort_unstable();
        corners
    };
    // Even permutations of the sorted corners have one orientation, odd ones the other.
    let even = |t: &[u32; 3]| (0..3).filter(|i| t[*i] < t[(i + 1) % 3]).count() == 2;
    let mut at: BTreeMap<[u32; 3], [Vec<usize>; 2]> = BTreeMap::new();
    for (i, t) in mesh.triangles.iter().enumerate() {
        at.entry(sorted(t)).or_default()[usize::from(even(t))].push(i);
    }
    let pairs = at.values().flat_map(|[odd, even]| odd.iter().zip(even).flat_map(|(a, b)| [*a, *b]));
    let dropped: BTreeSet<usize> = pairs.collect();
    if !dropped.is_empty() {
        let mut index = 0..;
        mesh.triangles.retain(|_| !dropped.contains(&index.next().unwrap_or_default()));
        drop_unused(mesh);
    }
    dropped.len() / 2
}

/// Removes triangles without area. A triangle is dropped if it shares no edge with exactly one other triangle.
/// Otherwise its longest edge is flipped, which leaves the surface unchanged, because the opposite corner lies on that
/// edge. Returns the number of removed triangles. Indices must be valid.
pub fn remove_flat(mesh: &mut TriMesh) -> usize {
    let mut removed = 0;
    // A chain of flat triangles needs one pass for each; triangles that remain are rejected later, with their location.
    for _ in 0..64 {
        let Some(done) = remove_flat_once(mesh) else { break };
        removed += done;
    }
    if removed > 0 {
        drop_unused(mesh);
    }
    removed
}

/// Removes flat triangles in one pass over the mesh; returns their number, or None if none was removed.
fn remove_flat_once(mesh: &mut TriMesh) -> Option<usize> {
    let flat: Vec<usize> = (0..mesh.triangles.len()).filter(|t| is_flat(mesh.corners(*t))).collect();
    if flat.is_empty() {
        return None;
    }
    let mut at: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for side in half_edges(mesh) {
        at.entry(side.ends).or_default().push(side.triangle as usize);
    }
    let (mut touched, mut dropped, mut done) = (BTreeSet::new(), BTreeSet::new(), 0);
    for t in flat {
        let corners = mesh.triangles[t];
        let edges = [0, 1, 2].map(|i| [corners[i], corners[(i + 1) % 3]]);
        let beside = edges.map(|[a, b]| {
            let all = &at[&[a.min(b), a.max(b)]];
            all.iter().copied().filter(|o| *o != t).collect::<Vec<_>>()
        });
        if touched.contains(&t) || beside.iter().flatten().any(|o| touched.contains(o)) {
            continue;
        }
        if beside.iter().all(|others| others.len() != 1) {
            dropped.insert(t);
            touched.extend(beside.into_iter().flatten().chain([t]));
            done += 1;
            continue;
        }
        let length = |i: usize| {
            let [a, b] = edges[i].map(|v| mesh.vertices[v as usize]);
            a.distance_squared(b)
        };
        let longest = (0..3).fold(0, |best, i| if length(i) > length(best) { i } else { best });
        let ([a, b], m) = (edges[longest], corners[(longest + 2) % 3]);
        let [other] = beside[longest][..] else { continue };
        let Some(c) = opposite_corner(mesh.triangles[other], [b, a]) else { continue };
        if c == m {
            // Coincident triangles: both are dropped.
            dropped.extend([t, other]);
        } else if at.contains_key(&[m.min(c), m.max(c)]) {
            continue;
        } else {
            mesh.triangles[t] = [a, c, m];
            mesh.triangles[other] = [c, b, m];
        }
        touched.extend(beside.into_iter().flatten().chain([t]));
        done += 1;
    }
    let mut index = 0..;
    mesh.triangles.retain(|_| !dropped.contains(&index.next().unwrap_or_default()));
    (done > 0).then_some(done)
}

/// Returns the corner of `triangle` opposite to its directed edge `from -> to`.
fn opposite_corner(triangle: [u32; 3], edge: [u32; 2]) -> Option<u32> {
    let i = (0..3).find(|i| [triangle[*i], triangle[(i + 1) % 3]] == edge)?;
    Some(triangle[(i + 2) % 3])
}
