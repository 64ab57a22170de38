//! Self-intersections of a closed surface.

use crate::Aabb;
use crate::mesh::shells::shells;
use crate::mesh::weld::tolerance;
use crate::mesh::{TriMesh, format_point};
use crate::shape::facet::Facet;
use crate::shape::winding::Winding;
use glam::DVec3;
use rayon::prelude::*;

/// Depth of an overlap over the object's largest size above which it is rejected: 3 um for a lemon. Shallower overlaps,
/// such as folds in scans, are not detected by a pad.
pub(crate) const MAX_OVERLAP: f64 = 1e-4;

/// Intersection of two triangles next to which the winding number is neither 0 nor 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Overlap {
    /// Indices of the two triangles.
    pub triangles: [u32; 2],
    /// Mean of their common points, m.
    pub position: DVec3,
}

/// Overlaps of a surface.
#[derive(Debug, Clone, Default)]
pub(crate) struct Overlaps {
    /// First overlap that is deeper than [`MAX_OVERLAP`].
    pub deep: Option<Overlap>,
    /// Number of pairs of triangles that overlap less deeply.
    pub shallow: usize,
}

/// Finds overlaps among all pairs of triangles that intersect, other than at common corners and edges. A pair overlaps
/// if the winding number next to the intersection is neither 0 nor 1; parts that only touch do not. `mesh` must be
/// closed and all its shells correctly oriented.
pub(crate) fn find_overlaps(mesh: &TriMesh) -> Overlaps {
    let winding = Winding::new(mesh);
    let bounds = winding.bvh.bounds();
    let (deep, shallow) = (MAX_OVERLAP * bounds.size().max_element(), 4.0 * tolerance(mesh));
    let found: Vec<(Option<Overlap>, usize)> = (0..winding.bvh.facets.len())
        .into_par_iter()
        .map(|i| {
            let (one, mut worst, mut count) = (&winding.bvh.facets[i], None, 0);
            winding.bvh.overlapping(&one.aabb(), |j| {
                // Each pair once.
                if worst.is_some() || j as usize <= i {
                    return;
                }
                let other = &winding.bvh.facets[j as usize];
                let triangles = [one.triangle, other.triangle];
                let Some(place) = intersection_centroid(mesh, triangles) else { return };
                if has_invalid_winding(&winding, place, [one.n, other.n], deep) {
                    worst = Some(Overlap { triangles, position: place });
                } else if has_invalid_winding(&winding, place, [one.n, other.n], shallow) {
                    count += 1;
                }
            });
            (worst, count)
        })
        .collect();
    Overlaps {
        deep: found.iter().filter_map(|f| f.0).min_by_key(|c| c.triangles),
        shallow: found.iter().map(|f| f.1).sum(),
    }
}

impl Overlaps {
    /// Returns the reason for the rejection of the surface, in one sentence.
    pub fn error_message(&self, mesh: &TriMesh) -> Option<String> {
        let Overlap { mut triangles, position: place } = self.deep?;
        triangles.sort_unstable();
        let shells = shells(mesh);
        let part = |t: &u32| shells.iter().position(|s| s.triangles.binary_search(t).is_ok());
        let what = if part(&triangles[0]) == part(&triangles[1]) {
            "the surface passes through itself"
        } else {
            "two parts of the surface overlap"
        };
        Some(format!(
            "{what}: its triangles {} and {} (0-based) cross near {}; unite its parts in the program that created it",
            triangles[0],
            triangles[1],
            format_point(place)
        ))
    }
}

/// Returns true if the winding number is neither 0 nor 1 at the distance `distance_bound` (m) from the point `place`,
/// where two facets with the normals `n` intersect, in one of the four wedges between them.
fn has_invalid_winding(winding: &Winding, place: DVec3, n: [DVec3; 2], away: f64) -> bool {
    let wedges = [-n[0] - n[1], n[0] + n[1], n[0] - n[1], n[1] - n[0]];
    wedges.into_iter().filter(|d| d.length() > 1e-3).any(|d| {
        let q = place + away * d.normalize();
        // On the surface itself, as next to coplanar faces, the winding number is not meaningful.
        let clear = winding.bvh.nearest(q, (f64::INFINITY, u32::MAX)).0 > (1e-3 * away).powi(2);
        clear && !(-0.5..=1.5).contains(&winding.at(q))
    })
}

/// Returns the mean of the common points of two triangles, except a common corner; None if there are none, or if they
/// share an edge.
fn intersection_centroid(mesh: &TriMesh, pair: [u32; 2]) -> Option<DVec3> {
    let [s, t] = pair.map(|t| mesh.triangles[t as usize]);
    let shared: Vec<u32> = s.into_iter().filter(|v| t.contains(v)).collect();
    let [p, q] = pair.map(|t| mesh.corners(t as usize));
    let size = Aabb::from_points(p.into_iter().chain(q)).size().max_element();
    let rounding = 1e-12 * size;
    let mut points = intersection_points(p, q, rounding);
    points.extend(intersection_points(q, p, rounding));
    match shared[..] {
        [] => {}
        [corner] => {
            let corner = mesh.vertices[corner as usize];
            points.retain(|x| x.distance(corner) > 1e-6 * size);
        }
        _ => return None,
    }
    (!points.is_empty()).then(|| points.iter().sum::<DVec3>() / points.len() as f64)
}

/// Returns the points where the sides of triangle `p` cross triangle `q`; for a side in the plane of `q`, the ends of
/// its part inside `q`.
fn intersection_points(p: [DVec3; 3], q: [DVec3; 3], rounding: f64) -> Vec<DVec3> {
    let Some(facet) = Facet::new(q, 0) else { return Vec::new() };
    let height = p.map(|x| {
        let h = facet.n.dot(x - facet.origin);
        if h.abs() <= rounding { 0.0 } else { h }
    });
    let mut points = Vec::new();
    for i in 0..3 {
        let (a, b, h, k) = (p[i], p[(i + 1) % 3], height[i], height[(i + 1) % 3]);
        if h == 0.0 && k == 0.0 {
            if let Some((from, to)) = facet.clip(a, b, rounding) {
                points.extend([a.lerp(b, from), a.lerp(b, to)]);
            }
        } else if h * k <= 0.0 {
            let x = a.lerp(b, h / (h - k));
            if facet.edge_distance(x) >= -rounding {
                points.push(x);
            }
        }
    }
    points
}
