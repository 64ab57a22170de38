//! Closest point of one face of a deformed pad surface.

use super::folds;
use super::surface::{ON_RIM, SurfaceFace, face_frame, tangents};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Closest point of the surface to a query point.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct ClosestPoint {
    /// Index of the face that it lies on.
    pub face: usize,
    /// Barycentric coordinates on the face.
    pub l: [f64; 3],
    /// Signed distance of the query point, m; negative inside the gel.
    pub gap: f64,
    /// Unit direction of increasing distance: the pad's outward normal.
    pub normal: DVec3,
    /// Cosine of the angle between the direction to the query point and the normal of the face.
    pub(crate) facing: f64,
    /// Flag: the point lies on the extension of the face beyond its rim, and is not the nearest point of the surface.
    pub(crate) extended: bool,
}

impl ClosestPoint {
    /// Creates a closest point from known values.
    pub(crate) fn at(face: usize, l: [f64; 3], gap: f64, normal: DVec3) -> Self {
        Self { face, l, gap, normal, facing: 1.0, extended: false }
    }

    /// Returns this closest point for a query point on the other side.
    pub(crate) fn flipped(self) -> Self {
        Self { gap: -self.gap, normal: -self.normal, ..self }
    }
}

/// Closest point of one face: Gauss-Newton on the barycentric coordinates, constrained to the triangle. A folded face,
/// or one on which this does not converge, is searched from several starting points.
pub(crate) fn on_face(index: usize, face: &SurfaceFace, x: &[DVec3], y: DVec3) -> ClosestPoint {
    let [a, b, c] = face.corners.map(|n| x[n as usize]);
    let mut l = clamp_to_triangle(project_flat(a, b, c, y), a, b, c, y);
    if is_folded(face, x) {
        l = folds::closest(face, x, y);
    } else if face.mids.is_some() {
        for _ in 0..6 {
            let Some((s, t)) = gauss_newton(face, x, l, y) else { break };
            let mut next = [l[0] - s - t, l[1] + s, l[2] + t];
            if next.iter().any(|v| *v < 0.0) {
                let at = clip_to_triangle(next);
                let k = (0..3).min_by(|a, b| at[*a].total_cmp(&at[*b])).unwrap_or(0);
                next = step_on_edge(face, x, at, k, y);
            }
            let moved = (next[1] - l[1]).abs() + (next[2] - l[2]).abs();
            l = next;
            if moved < 1e-12 {
                break;
            }
        }
        // On a curved edge, steps over the face do not settle: the last iterations run along the edge.
        if let Some(k) = (0..3).find(|k| l[*k] <= 0.0) {
            l = minimise_on_edge(face, x, k, y, l);
        }
        if !is_minimum(face, x, l, y) {
            l = folds::closest(face, x, y);
        }
    }
    let (p, face_normal) = face_frame(face, x, l);
    let away = y - p;
    let distance = away.length();
    let side = if away.dot(face_normal) < 0.0 { -1.0 } else { 1.0 };
    let interior = l.iter().all(|v| *v > ON_RIM);
    // On the rim of a face the direction to the point is the normal; in the interior both agree, and the normal of the
    // face is exact even at distance zero.
    let normal = if interior || face.touches(x, distance) { face_normal } else { away * (side / distance) };
    let gap = if interior { away.dot(face_normal) } else { side * distance };
    let facing = if interior || distance == 0.0 { 1.0 } else { away.dot(face_normal).abs() / distance };
    ClosestPoint { face: index, l, gap, normal, facing, extended: false }
}

/// Sagitta of an edge over its chord above which a face is folded: the tangents at its ends then differ by about 70
/// degrees.
const FOLDED_SAGITTA_RATIO: f64 = 0.15;
/// Largest sine of the angle between the normal of the face and the direction to a converged closest point.
const LARGEST_NORMAL_SINE: f64 = 1e-3;

/// Returns true if the face is curved so much that the distance to a point may have several minima on it.
fn is_folded(face: &SurfaceFace, x: &[DVec3]) -> bool {
    let Some(mids) = face.mids else { return false };
    (0..3).any(|k| {
        let [a, b] = [k, (k + 1) % 3].map(|i| x[face.corners[i] as usize]);
        x[mids[k] as usize].distance_squared((a + b) * 0.5)
            > FOLDED_SAGITTA_RATIO * FOLDED_SAGITTA_RATIO * a.distance_squared(b)
    })
}

/// Returns true if no point of the face in the vicinity of `l` is nearer to `y`.
fn is_minimum(face: &SurfaceFace, x: &[DVec3], l: [f64; 3], y: DVec3) -> bool {
    let (p, d1, d2) = tangents(face, x, l);
    let away = y - p;
    let reach = LARGEST_NORMAL_SINE * away.length();
    // No direction along the three edges that stays within the face may reduce the distance.
    let along = [d1, d2 - d1, -d2];
    (0..3).all(|k| {
        let (slope, most) = (away.dot(along[k]), reach * along[k].length());
        let (back, forth) = (l[k], l[(k + 1) % 3]);
        (slope <= most || back <= ON_RIM) && (slope >= -most || forth <= ON_RIM)
    })
}

/// Extension of a face beyond its rim, in barycentric coordinates.
const FACE_EXTENSION: f64 = 0.05;

/// The closest point of `y` on a face extended beyond its rim; None if it lies beyond the extension.
pub(crate) fn on_extended_face(index: usize, face: &SurfaceFace, x: &[DVec3], y: DVec3) -> Option<ClosestPoint> {
    let [a, b, c] = face.corners.map(|n| x[n as usize]);
    let mut l = project_flat(a, b, c, y);
    let near = |l: &[f64; 3]| l.iter().all(|v| *v > -FACE_EXTENSION);
    if face.mids.is_some() {
        l = clamp_to_triangle(l, a, b, c, y);
        for _ in 0..6 {
            let Some((s, t)) = gauss_newton(face, x, l, y).filter(|_| near(&l)) else { break };
            l = [l[0] - s - t, l[1] + s, l[2] + t];
            if s.abs() + t.abs() < 1e-12 {
                break;
            }
        }
    }
    let (p, normal) = face_frame(face, x, l);
    near(&l).then(|| ClosestPoint { extended: true, ..ClosestPoint::at(index, l, (y - p).dot(normal), normal) })
}

/// Gauss-Newton step of `l1` and `l2` towards the closest point of `y`; None if the face is degenerate.
fn gauss_newton(face: &SurfaceFace, x: &[DVec3], l: [f64; 3], y: DVec3) -> Option<(f64, f64)> {
    let (p, d1, d2) = tangents(face, x, l);
    let (g11, g12, g22) = (d1.dot(d1), d1.dot(d2), d2.dot(d2));
    let (r1, r2) = (d1.dot(y - p), d2.dot(y - p));
    let det = g11 * g22 - g12 * g12;
    (det > 0.0).then(|| ((g22 * r1 - g12 * r2) / det, (g11 * r2 - g12 * r1) / det))
}

/// One Gauss-Newton step along the edge opposite to corner `k`, on which `l` lies.
fn step_on_edge(face: &SurfaceFace, x: &[DVec3], l: [f64; 3], k: usize, y: DVec3) -> [f64; 3] {
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let (p, d1, d2) = tangents(face, x, l);
    let d = [DVec3::ZERO, d1, d2];
    let tangent = d[j] - d[i];
    let by = (tangent.dot(y - p) / tangent.length_squared()).clamp(-l[j], l[i]);
    let mut next = l;
    (next[i], next[j]) = (l[i] - by, l[j] + by);
    next
}

/// Coordinates of the point of the edge opposite to corner `k` that is closest to `y`.
pub(crate) fn on_edge(face: &SurfaceFace, x: &[DVec3], k: usize, y: DVec3) -> [f64; 3] {
    let mut middle = [0.5; 3];
    middle[k] = 0.0;
    minimise_on_edge(face, x, k, y, middle)
}

/// Coordinates of the same point, found by iteration from a point `l` on the edge.
fn minimise_on_edge(face: &SurfaceFace, x: &[DVec3], k: usize, y: DVec3, mut l: [f64; 3]) -> [f64; 3] {
    for _ in 0..8 {
        let next = step_on_edge(face, x, l, k, y);
        let moved = (0..3).map(|i| (next[i] - l[i]).abs()).fold(0.0, f64::max);
        l = next;
        if moved < 1e-12 {
            break;
        }
    }
    l
}

/// Barycentric coordinates of the projection of `y` onto the plane of a triangle.
pub(crate) fn project_flat(a: DVec3, b: DVec3, c: DVec3, y: DVec3) -> [f64; 3] {
    let (u, v, w) = (b - a, c - a, y - a);
    let (uu, uv, vv, wu, wv) = (u.dot(u), u.dot(v), v.dot(v), w.dot(u), w.dot(v));
    let det = uu * vv - uv * uv;
    let (s, t) = ((vv * wu - uv * wv) / det, (uu * wv - uv * wu) / det);
    [1.0 - s - t, s, t]
}

/// The closest point inside a flat triangle, from the projection onto its plane (Ericson 2005, section 5.1.5).
pub(crate) fn clamp_to_triangle(l: [f64; 3], a: DVec3, b: DVec3, c: DVec3, y: DVec3) -> [f64; 3] {
    if l.iter().all(|v| *v >= 0.0) {
        return l;
    }
    let corners = [a, b, c];
    let mut best = ([1.0, 0.0, 0.0], f64::INFINITY);
    for i in 0..3 {
        let j = (i + 1) % 3;
        let edge = corners[j] - corners[i];
        let t = ((y - corners[i]).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        let distance = (corners[i] + edge * t).distance_squared(y);
        if distance < best.1 {
            let mut l = [0.0; 3];
            (l[i], l[j]) = (1.0 - t, t);
            best = (l, distance);
        }
    }
    best.0
}

/// Sets negative coordinates to zero and restores the sum of one.
fn clip_to_triangle(l: [f64; 3]) -> [f64; 3] {
    let l = l.map(|v| v.max(0.0));
    let sum: f64 = l.iter().sum();
    if sum > 0.0 { l.map(|v| v / sum) } else { [1.0, 0.0, 0.0] }
}
