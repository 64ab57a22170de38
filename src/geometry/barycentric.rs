//! Barycentric coordinates of a triangle in the plane.

use glam::DVec2;

/// Computes the barycentric coordinates of `p` in a triangle.
pub fn barycentric(p: DVec2, [a, b, c]: [DVec2; 3]) -> [f64; 3] {
    let whole = (b - a).perp_dot(c - a);
    let [u, v] = [(b - p).perp_dot(c - p) / whole, (c - p).perp_dot(a - p) / whole];
    [u, v, 1.0 - u - v]
}
