//! Closest point of a deformed pad surface.

use super::cells::{Cells, NEAR};
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
    pub(super) facing: f64,
}

impl Foot {
    /// A foot that is known.
    pub(super) fn at(face: usize, l: [f64; 3], gap: f64, normal: DVec3) -> Self {
        Self { face, l, gap, normal, facing: 1.0 }
    }
}

/// Bounds of the faces of a deformed surface, to skip most of them.
#[derive(Debug, Clone, Default)]
pub struct FaceBounds {
    boxes: Vec<[DVec3; 2]>,
    /// How far each face bulges from its flat triangle, m.
    bulges: Vec<f64>,
    cells: Cells,
    min: DVec3,
    max: DVec3,
}

impl FaceBounds {
    /// Bounds of every face at node positions `x`.
    pub fn update(&mut self, surface: &ContactSurface, x: &[DVec3]) {
        self.boxes.clear();
        self.bulges.clear();
        (self.min, self.max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for face in surface.faces.iter() {
            let mut nodes = [DVec3::ZERO; 6];
            let (mut count, mut sagitta) = (3, 0.0_f64);
            for (k, n) in face.corners.iter().enumerate() {
                nodes[k] = x[*n as usize];
            }
            if let Some(mids) = face.mids {
                for (k, n) in mids.iter().enumerate() {
                    // The Bezier control point of the edge bounds the curve: 2 m - (a + b) / 2.
                    let middle = (nodes[k] + nodes[(k + 1) % 3]) * 0.5;
                    nodes[3 + k] = x[*n as usize] * 2.0 - middle;
                    sagitta = sagitta.max(x[*n as usize].distance(middle));
                }
                count = 6;
            }
            self.bulges.push(BULGE * sagitta);
            let around =
                nodes[..count].iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |b, p| [b[0].min(*p), b[1].max(*p)]);
            (self.min, self.max) = (self.min.min(around[0]), self.max.max(around[1]));
            self.boxes.push(around);
        }
        self.cells.update(&self.boxes, self.min, self.max);
    }

    /// Closest point of the surface to `y` if nearer than `reach` outside, or anywhere inside the gel near the surface.
    pub fn closest(&self, surface: &ContactSurface, x: &[DVec3], y: DVec3, reach: f64) -> Option<Foot> {
        if y.cmplt(self.min - reach).any() || y.cmpgt(self.max + reach).any() {
            return None;
        }
        let best = self.near(surface, x, y, NEAR);
        let best = best.or_else(|| self.nearest(surface, x, y, 0..self.boxes.len(), f64::INFINITY));
        best.filter(|foot| foot.gap < reach)
    }

    /// Closest point of the surface to `y` if nearer than `limit`, up to [`NEAR`], inside or outside.
    pub(super) fn near(&self, surface: &ContactSurface, x: &[DVec3], y: DVec3, limit: f64) -> Option<Foot> {
        let faces = self.cells.at(y).iter().map(|i| *i as usize);
        self.nearest(surface, x, y, faces, limit)
    }

    /// How far `y` is outside the surface at least, m; exact where that is near, not positive inside.
    pub fn outside(&self, surface: &ContactSurface, x: &[DVec3], y: DVec3) -> f64 {
        let beyond = y.clamp(self.min, self.max).distance(y);
        if beyond > NEAR {
            return beyond;
        }
        self.closest(surface, x, y, f64::INFINITY).map_or(f64::INFINITY, |foot| foot.gap)
    }

    /// Closest point on those of `faces` that are nearer than `limit`.
    fn nearest(
        &self,
        surface: &ContactSurface,
        x: &[DVec3],
        y: DVec3,
        faces: impl Iterator<Item = usize> + Clone,
        limit: f64,
    ) -> Option<Foot> {
        // The face that promises to be nearest goes first: it leaves few others that could win.
        let (mut first, mut least) = (None, limit);
        for i in faces.clone() {
            let away = self.away(i, &surface.faces[i], x, y, least);
            if away < least {
                (first, least) = (Some(i), away);
            }
        }
        let (mut best, mut nearest): (Option<Foot>, f64) = (None, limit);
        for i in first.into_iter().chain(faces.filter(|i| Some(*i) != first)) {
            let most = nearest * (1.0 + TIE);
            if self.away(i, &surface.faces[i], x, y, most) > most {
                continue;
            }
            let foot = on_face(i, &surface.faces[i], x, y);
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
        best.map(|foot| foot.signed(surface, x, y))
    }

    /// How far face `i` is from `y` at least, m: its flat triangle, less how far it bulges from it. No more is found out than that it is
    /// beyond `limit` (m), where its box is.
    pub(super) fn away(&self, i: usize, face: &Face, x: &[DVec3], y: DVec3, limit: f64) -> f64 {
        let [low, high] = self.boxes[i];
        let beyond = y.clamp(low, high).distance(y);
        if beyond > limit {
            return beyond;
        }
        let [a, b, c] = face.corners.map(|n| x[n as usize]);
        let l = clamp_to_triangle(project_flat(a, b, c, y), a, b, c, y);
        ((a * l[0] + b * l[1] + c * l[2]).distance(y) - self.bulges[i]).max(beyond)
    }
}

/// How far a quadratic face may be from its flat triangle over how far the middles of its edges are: the most that the sum of their
/// shape functions can be.
const BULGE: f64 = 4.0 / 3.0;
/// Relative difference of distances that is rounding.
const TIE: f64 = 1e-9;
/// Barycentric coordinate below which a point lies on the rim of its face.
pub(super) const ON_RIM: f64 = 1e-9;

/// Closest point of one face: Gauss-Newton on the barycentric coordinates, kept inside the triangle.
pub(super) fn on_face(index: usize, face: &Face, x: &[DVec3], y: DVec3) -> Foot {
    let [a, b, c] = face.corners.map(|n| x[n as usize]);
    let mut l = clamp_to_triangle(project_flat(a, b, c, y), a, b, c, y);
    if face.mids.is_some() {
        for _ in 0..6 {
            let Some((s, t)) = gauss_newton(face, x, l, y) else { break };
            let mut next = [l[0] - s - t, l[1] + s, l[2] + t];
            if next.iter().any(|v| *v < 0.0) {
                let at = restrict(next);
                let k = (0..3).min_by(|a, b| at[*a].total_cmp(&at[*b])).unwrap_or(0);
                next = along_rim(face, x, at, k, y);
            }
            let moved = (next[1] - l[1]).abs() + (next[2] - l[2]).abs();
            l = next;
            if moved < 1e-12 {
                break;
            }
        }
        // On a bent rim the steps over the face keep disturbing each other: the last ones go along it.
        if let Some(k) = (0..3).find(|k| l[*k] <= 0.0) {
            l = along_edge(face, x, k, y, l);
        }
    }
    let (p, face_normal) = face_frame(face, x, l);
    let away = y - p;
    let distance = away.length();
    let side = if away.dot(face_normal) < 0.0 { -1.0 } else { 1.0 };
    let interior = l.iter().all(|v| *v > ON_RIM);
    // On the rim of a face the direction to the point is the normal; on its inside both agree, and the frame is exact
    // also at distance zero.
    let normal = if interior || distance < 1e-9 { face_normal } else { away * (side / distance) };
    let gap = if interior { away.dot(face_normal) } else { side * distance };
    let facing = if interior || distance == 0.0 { 1.0 } else { away.dot(face_normal).abs() / distance };
    Foot { face: index, l, gap, normal, facing }
}

/// How far a face is carried on beyond its rim, in barycentric coordinates.
const BEYOND: f64 = 0.05;

/// The foot of `y` on a face carried on a little beyond its rim; None where that is not enough.
pub(super) fn carried_on(index: usize, face: &Face, x: &[DVec3], y: DVec3) -> Option<Foot> {
    let [a, b, c] = face.corners.map(|n| x[n as usize]);
    let mut l = project_flat(a, b, c, y);
    let near = |l: &[f64; 3]| l.iter().all(|v| *v > -BEYOND);
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
    near(&l).then(|| Foot::at(index, l, (y - p).dot(normal), normal))
}

/// Change of `l1` and `l2` towards the foot of `y`; None where the face is degenerate.
fn gauss_newton(face: &Face, x: &[DVec3], l: [f64; 3], y: DVec3) -> Option<(f64, f64)> {
    let (p, d1, d2) = tangents(face, x, l);
    let (g11, g12, g22) = (d1.dot(d1), d1.dot(d2), d2.dot(d2));
    let (r1, r2) = (d1.dot(y - p), d2.dot(y - p));
    let det = g11 * g22 - g12 * g12;
    (det > 0.0).then(|| ((g22 * r1 - g12 * r2) / det, (g11 * r2 - g12 * r1) / det))
}

/// One Gauss-Newton step along the edge opposite to corner `k`, on which `l` lies.
fn along_rim(face: &Face, x: &[DVec3], l: [f64; 3], k: usize, y: DVec3) -> [f64; 3] {
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
pub(super) fn on_edge(face: &Face, x: &[DVec3], k: usize, y: DVec3) -> [f64; 3] {
    let mut middle = [0.5; 3];
    middle[k] = 0.0;
    along_edge(face, x, k, y, middle)
}

/// The same from a point `l` on the edge.
fn along_edge(face: &Face, x: &[DVec3], k: usize, y: DVec3, mut l: [f64; 3]) -> [f64; 3] {
    for _ in 0..8 {
        let next = along_rim(face, x, l, k, y);
        let moved = (0..3).map(|i| (next[i] - l[i]).abs()).fold(0.0, f64::max);
        l = next;
        if moved < 1e-12 {
            break;
        }
    }
    l
}

/// Position and derivatives in `l1`, `l2` (with `l0 = 1 - l1 - l2`) of a quadratic face.
pub(super) fn tangents(face: &Face, x: &[DVec3], l: [f64; 3]) -> (DVec3, DVec3, DVec3) {
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

/// Cuts negative coordinates and restores their sum.
fn restrict(l: [f64; 3]) -> [f64; 3] {
    let l = l.map(|v| v.max(0.0));
    let sum: f64 = l.iter().sum();
    if sum > 0.0 { l.map(|v| v / sum) } else { [1.0, 0.0, 0.0] }
}
