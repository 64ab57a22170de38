//! Closest point of a deformed pad surface.

use super::surface::{ContactSurface, Face, face_frame};
use glam::DVec3;

/// Closest point of the surface to a query point.
#[derive(Debug, Clone, Copy)]
pub struct Foot {
    /// Face it lies on.
    pub face: usize,
    /// Barycentric coordinates on the face.
    pub l: [f64; 3],
    /// Signed distance of the query point, m; negative inside the gel.
    pub gap: f64,
    /// Unit direction of growing distance: the pad's outward normal.
    pub normal: DVec3,
    /// How squarely the query point lies over the face: cosine of its direction with the face's normal.
    facing: f64,
}

/// Bounds of the faces of a deformed surface, to skip most of them.
#[derive(Debug, Clone, Default)]
pub struct FaceBounds {
    spheres: Vec<(DVec3, f64)>,
    min: DVec3,
    max: DVec3,
}

impl FaceBounds {
    /// Bounds of every face at node positions `x`.
    pub fn update(&mut self, surface: &ContactSurface, x: &[DVec3]) {
        self.spheres.clear();
        (self.min, self.max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for face in surface.faces.iter() {
            let mut nodes = [DVec3::ZERO; 6];
            let mut count = 3;
            for (k, n) in face.corners.iter().enumerate() {
                nodes[k] = x[*n as usize];
            }
            if let Some(mids) = face.mids {
                for (k, n) in mids.iter().enumerate() {
                    // The Bezier control point of the edge bounds the curve: 2 m - (a + b) / 2.
                    nodes[3 + k] = x[*n as usize] * 2.0 - (nodes[k] + nodes[(k + 1) % 3]) * 0.5;
                }
                count = 6;
            }
            let nodes = &nodes[..count];
            let center = nodes.iter().sum::<DVec3>() / count as f64;
            let radius = nodes.iter().map(|p| p.distance(center)).fold(0.0, f64::max);
            self.spheres.push((center, radius));
            for p in nodes {
                (self.min, self.max) = (self.min.min(*p), self.max.max(*p));
            }
        }
    }

    /// Closest point of the surface to `y` if nearer than `reach` outside, or anywhere inside the gel near the surface.
    ///
    /// The face `last` is kept while the foot lies on it or just beyond its rim: where two faces meet, the normal jumps, and
    /// an equilibrium right there would make Newton hop between them for ever.
    pub fn closest(
        &self,
        surface: &ContactSurface,
        x: &[DVec3],
        y: DVec3,
        reach: f64,
        last: Option<usize>,
    ) -> Option<Foot> {
        if let Some(i) = last {
            let foot = on_face(i, &surface.faces[i], x, y, BEYOND);
            if foot.l.iter().all(|v| *v > -BEYOND) && foot.gap.abs() < reach {
                return Some(foot);
            }
        }
        if y.cmplt(self.min - reach).any() || y.cmpgt(self.max + reach).any() {
            return None;
        }
        // A face can only win if its sphere comes closer than the best foot; nearly always that is a near one.
        let best =
            self.nearest(surface, x, y, DEEPEST.max(reach)).or_else(|| self.nearest(surface, x, y, f64::INFINITY));
        best.filter(|foot| foot.gap < reach)
    }

    /// How far `y` is outside the surface, m; not positive inside.
    pub fn outside(&self, surface: &ContactSurface, x: &[DVec3], y: DVec3) -> f64 {
        self.nearest(surface, x, y, f64::INFINITY).map_or(f64::INFINITY, |foot| foot.gap)
    }

    /// Closest point among the faces nearer than `limit`.
    fn nearest(&self, surface: &ContactSurface, x: &[DVec3], y: DVec3, limit: f64) -> Option<Foot> {
        let (mut best, mut nearest) = (None, limit);
        let squared = |i: usize| y.distance_squared(self.spheres[i].0);
        // The face whose centre is nearest first: it leaves few others that could win.
        let all = 0..self.spheres.len();
        let first = all.clone().map(|i| (squared(i), i)).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i);
        for i in first.into_iter().chain(all.filter(|i| Some(*i) != first)) {
            if squared(i) < (nearest + self.spheres[i].1).powi(2) {
                let foot = on_face(i, &surface.faces[i], x, y, 0.0);
                let distance = foot.gap.abs();
                // On the edge that two faces share only the one that the point lies over knows on which side it is.
                let better = match best {
                    Some(Foot { facing, .. }) if (distance - nearest).abs() <= TIE * nearest => foot.facing > facing,
                    _ => distance < nearest,
                };
                if better {
                    nearest = distance;
                    best = Some(foot);
                }
            }
        }
        best
    }
}

/// Depth inside the gel up to which a point is looked for first, m: more than one iteration moves it.
const DEEPEST: f64 = 2e-3;
/// Relative difference of distances that is rounding.
const TIE: f64 = 1e-9;
/// How far beyond its rim a face stays the closest one, in barycentric coordinates.
const BEYOND: f64 = 0.05;

/// Closest point of one face: Gauss-Newton on the barycentric coordinates, kept inside the triangle or at most `beyond`
/// outside it.
fn on_face(index: usize, face: &Face, x: &[DVec3], y: DVec3, beyond: f64) -> Foot {
    let [a, b, c] = face.corners.map(|n| x[n as usize]);
    let mut l = project_flat(a, b, c, y);
    if beyond == 0.0 || face.mids.is_some() {
        l = clamp_to_triangle(l, a, b, c, y);
    }
    if face.mids.is_some() {
        for _ in 0..6 {
            let (p, d1, d2) = tangents(face, x, l);
            let (g11, g12, g22) = (d1.dot(d1), d1.dot(d2), d2.dot(d2));
            let (r1, r2) = (d1.dot(y - p), d2.dot(y - p));
            let det = g11 * g22 - g12 * g12;
            if det <= 0.0 {
                break;
            }
            let (s, t) = ((g22 * r1 - g12 * r2) / det, (g11 * r2 - g12 * r1) / det);
            let mut next = [l[0] - s - t, l[1] + s, l[2] + t];
            if next.iter().any(|v| *v < -beyond) {
                next = along_rim(face, x, restrict(next, beyond), y, beyond);
            }
            let moved = (next[1] - l[1]).abs() + (next[2] - l[2]).abs();
            l = next;
            if moved < 1e-12 {
                break;
            }
        }
    }
    let (p, face_normal) = face_frame(face, x, l);
    let away = y - p;
    let distance = away.length();
    let side = if away.dot(face_normal) < 0.0 { -1.0 } else { 1.0 };
    let interior = l.iter().all(|v| *v > 1e-9 - beyond);
    // On the rim of a face the direction to the point is the normal; on its inside both agree, and the frame is exact
    // also at distance zero.
    let normal = if interior || distance < 1e-9 { face_normal } else { away * (side / distance) };
    let gap = if interior { away.dot(face_normal) } else { side * distance };
    let facing = if interior || distance == 0.0 { 1.0 } else { away.dot(face_normal).abs() / distance };
    Foot { face: index, l, gap, normal, facing }
}

/// One Gauss-Newton step along the rim on which `l` lies.
fn along_rim(face: &Face, x: &[DVec3], l: [f64; 3], y: DVec3, beyond: f64) -> [f64; 3] {
    let k = (0..3).min_by(|a, b| l[*a].total_cmp(&l[*b])).unwrap_or(0);
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let (p, d1, d2) = tangents(face, x, l);
    let d = [DVec3::ZERO, d1, d2];
    let tangent = d[j] - d[i];
    let by = (tangent.dot(y - p) / tangent.length_squared()).clamp(-beyond - l[j], l[i] + beyond);
    let mut next = l;
    (next[i], next[j]) = (l[i] - by, l[j] + by);
    next
}

/// Position and derivatives in `l1`, `l2` (with `l0 = 1 - l1 - l2`) of a quadratic face.
fn tangents(face: &Face, x: &[DVec3], l: [f64; 3]) -> (DVec3, DVec3, DVec3) {
    let at = |n: u32| x[n as usize];
    let [a, b, c] = face.corners.map(at);
    match face.mids.map(|m| m.map(at)) {
        None => (face.stencil(l).position(x), b - a, c - a),
        Some([ab, bc, ca]) => {
            let corners =
                a * (l[0] * (2.0 * l[0] - 1.0)) + b * (l[1] * (2.0 * l[1] - 1.0)) + c * (l[2] * (2.0 * l[2] - 1.0));
            let p = corners + ab * (4.0 * l[0] * l[1]) + bc * (4.0 * l[1] * l[2]) + ca * (4.0 * l[2] * l[0]);
            let d0 = a * (4.0 * l[0] - 1.0) + (ab * l[1] + ca * l[2]) * 4.0;
            let d1 = b * (4.0 * l[1] - 1.0) + (ab * l[0] + bc * l[2]) * 4.0;
            let d2 = c * (4.0 * l[2] - 1.0) + (bc * l[1] + ca * l[0]) * 4.0;
            (p, d1 - d0, d2 - d0)
        }
    }
}

/// Barycentric coordinates of the projection of `y` onto the plane of a triangle.
fn project_flat(a: DVec3, b: DVec3, c: DVec3, y: DVec3) -> [f64; 3] {
    let (u, v, w) = (b - a, c - a, y - a);
    let (uu, uv, vv, wu, wv) = (u.dot(u), u.dot(v), v.dot(v), w.dot(u), w.dot(v));
    let det = uu * vv - uv * uv;
    let (s, t) = ((vv * wu - uv * wv) / det, (uu * wv - uv * wu) / det);
    [1.0 - s - t, s, t]
}

/// The closest point inside a flat triangle, from the projection onto its plane (Ericson 2005, section 5.1.5).
fn clamp_to_triangle(l: [f64; 3], a: DVec3, b: DVec3, c: DVec3, y: DVec3) -> [f64; 3] {
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

/// Cuts coordinates below `-beyond` and restores their sum.
fn restrict(l: [f64; 3], beyond: f64) -> [f64; 3] {
    let l = l.map(|v| v.max(-beyond) + beyond);
    let sum: f64 = l.iter().sum();
    let whole = 1.0 + 3.0 * beyond;
    if sum > 0.0 { l.map(|v| v / sum * whole - beyond) } else { [1.0, 0.0, 0.0] }
}
