//! Closest point of a folded quadratic face, on which the search from its flat triangle may end at any local minimum.

use super::surface::{ON_RIM, SurfaceFace, tangents};
use geometry::triangle6;
use glam::DVec3;

/// Maximum number of iterations from one start.
const MAX_NEWTON_ITERATIONS: u32 = 30;
/// Change of the coordinates below which the iterations stop.
const SMALLEST_COORDINATE_CHANGE: f64 = 1e-13;
/// Starting points of the search over the face, and along an edge.
const FACE_STARTS: [[f64; 3]; 4] = [
    [2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0],
    [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
    [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0],
    [1.0 / 3.0; 3],
];
const EDGE_STARTS: [f64; 3] = [1.0 / 6.0, 0.5, 5.0 / 6.0];

/// Barycentric coordinates of the nearest of all local minima that Newton's method finds on `face` from several
/// starting points.
pub(crate) fn closest(face: &SurfaceFace, x: &[DVec3], y: DVec3) -> [f64; 3] {
    let over = FACE_STARTS.into_iter().map(|l| minimise_on_face(face, x, y, l));
    let along = (0..3).flat_map(|k| EDGE_STARTS.map(|t| minimise_on_edge(face, x, y, k, t)));
    let corners = (0..3).map(|k| {
        let l = std::array::from_fn(|i| f64::from(u8::from(i == k)));
        (l, distance_squared(face, x, y, l))
    });
    over.chain(along).chain(corners).min_by(|a, b| a.1.total_cmp(&b.1)).map_or(FACE_STARTS[3], |(l, _)| l)
}

fn distance_squared(face: &SurfaceFace, x: &[DVec3], y: DVec3, l: [f64; 3]) -> f64 {
    face.stencil(l).position(x).distance_squared(y)
}

/// Minimises the squared distance over the face from `l`; moves along the rim where the search would leave the face.
/// Returns the coordinates and that distance.
fn minimise_on_face(face: &SurfaceFace, x: &[DVec3], y: DVec3, mut l: [f64; 3]) -> ([f64; 3], f64) {
    let [d11, d12, d22] = second_derivatives(face, x);
    let mut far = distance_squared(face, x, y, l);
    for _ in 0..MAX_NEWTON_ITERATIONS {
        let (p, d1, d2) = tangents(face, x, l);
        let away = y - p;
        let (r1, r2) = (d1.dot(away), d2.dot(away));
        let flat = [d1.dot(d1), d1.dot(d2), d2.dot(d2)];
        let bent = [flat[0] - away.dot(d11), flat[1] - away.dot(d12), flat[2] - away.dot(d22)];
        let convex = bent[0] > 0.0 && bent[0] * bent[2] > bent[1] * bent[1];
        let [a, b, c] = if convex { bent } else { flat };
        let det = a * c - b * b;
        if det <= 0.0 {
            break;
        }
        let (s, t) = ((c * r1 - b * r2) / det, (a * r2 - b * r1) / det);
        let mut step = [-s - t, s, t];
        if let Some(k) = (0..3).find(|k| l[*k] <= 0.0 && step[*k] < 0.0) {
            let mut along = [0.0, 0.0, 0.0];
            (along[(k + 1) % 3], along[(k + 2) % 3]) = (-1.0, 1.0);
            let [_, u, v] = along;
            let by = (r1 * u + r2 * v) / (a * u * u + 2.0 * b * u * v + c * v * v);
            step = along.map(|part| by * part);
        }
        // At most up to the rim.
        let most = (0..3).filter(|k| step[*k] < 0.0).map(|k| l[k] / -step[k]).fold(1.0, f64::min);
        let Some((next, nearer)) = backtrack(most, far, |alpha| {
            let next: [f64; 3] = std::array::from_fn(|k| {
                let v = l[k] + alpha * step[k];
                if v > ON_RIM { v } else { 0.0 }
            });
            (next, distance_squared(face, x, y, next))
        }) else {
            break;
        };
        let moved = (next[1] - l[1]).abs() + (next[2] - l[2]).abs();
        (l, far) = (next, nearer);
        if moved < SMALLEST_COORDINATE_CHANGE {
            break;
        }
    }
    (l, far)
}

/// Minimises the squared distance along the edge opposite to corner `k`, from the fraction `t` of its length.
fn minimise_on_edge(face: &SurfaceFace, x: &[DVec3], y: DVec3, k: usize, mut t: f64) -> ([f64; 3], f64) {
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let at = |t: f64| {
        let mut l = [0.0; 3];
        (l[i], l[j]) = (1.0 - t, t);
        l
    };
    let [d11, d12, d22] = second_derivatives(face, x);
    let bend = [d11 + d22 - d12 * 2.0, d22, d11][k];
    let mut far = distance_squared(face, x, y, at(t));
    for _ in 0..MAX_NEWTON_ITERATIONS {
        let (p, d1, d2) = tangents(face, x, at(t));
        let tangent = [d2 - d1, -d2, d1][k];
        let away = y - p;
        let (slope, flat) = (tangent.dot(away), tangent.length_squared());
        let bent = flat - away.dot(bend);
        let step = (slope / if bent > 0.0 { bent } else { flat }).clamp(-t, 1.0 - t);
        let shorter =
            backtrack(1.0, far, |alpha| (t + alpha * step, distance_squared(face, x, y, at(t + alpha * step))));
        let Some((next, nearer)) = shorter else { break };
        let moved = (next - t).abs();
        (t, far) = (next, nearer);
        if moved < SMALLEST_COORDINATE_CHANGE {
            break;
        }
    }
    (at(t), far)
}

/// Halves the step `alpha` until the squared distance is below `far`; returns the result with that distance, or None.
fn backtrack<T>(mut alpha: f64, far: f64, step: impl Fn(f64) -> (T, f64)) -> Option<(T, f64)> {
    for _ in 0..12 {
        let (next, nearer) = step(alpha);
        if nearer < far {
            return Some((next, nearer));
        }
        alpha *= 0.5;
    }
    None
}

/// Second derivatives of the position in `l1 l1`, `l1 l2` and `l2 l2`, constant on a face.
pub(crate) fn second_derivatives(face: &SurfaceFace, x: &[DVec3]) -> [DVec3; 3] {
    face.six_nodes(x).map_or([DVec3::ZERO; 3], |nodes| triangle6::second_derivatives(&nodes))
}
