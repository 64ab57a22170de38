//! Barycentric coordinates of a triangle in the plane.

use glam::DVec2;

/// Computes the barycentric coordinates of `p` in a triangle.
pub fn barycentric(p: DVec2, [a, b, c]: [DVec2; 3]) -> [f64; 3] {
    let whole = (b - a).perp_dot(c - a);
    let [u, v] = [(b - p).perp_dot(c - p) / whole, (c - p).perp_dot(a - p) / whole];
    [u, v, 1.0 - u - v]
}

/// Returns the smallest of the coordinates: negative outside the triangle, and decreasing with the distance from it.
pub fn min_coordinate(l: [f64; 3]) -> f64 {
    l.into_iter().fold(f64::INFINITY, f64::min)
}

/// Clamps coordinates to the triangle: sets negative ones to zero and normalises the sum to one.
pub fn clamp_to_triangle(l: [f64; 3]) -> [f64; 3] {
    let l = l.map(|v| v.max(0.0));
    let sum: f64 = l.iter().sum();
    l.map(|v| v / sum)
}
