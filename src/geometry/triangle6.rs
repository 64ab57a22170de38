//! Shape functions of the 6-node triangle on barycentric coordinates.
//!
//! Nodes: three corners, then the midpoints of (0,1), (1,2) and (2,0). Derivatives are in `l1` and `l2`, with
//! `l0 = 1 - l1 - l2`.

use glam::{DVec2, DVec3};

/// Returns the values of the shape functions at `l`.
#[inline]
pub fn values([l0, l1, l2]: [f64; 3]) -> [f64; 6] {
    let corner = |l: f64| l * (2.0 * l - 1.0);
    [corner(l0), corner(l1), corner(l2), 4.0 * l0 * l1, 4.0 * l1 * l2, 4.0 * l2 * l0]
}

/// Returns the derivatives of the shape functions at `l`.
#[inline]
pub fn derivatives([l0, l1, l2]: [f64; 3]) -> [DVec2; 6] {
    let corner = |along: DVec2, l: f64| along * (4.0 * l - 1.0);
    [
        corner(DVec2::NEG_ONE, l0),
        corner(DVec2::X, l1),
        corner(DVec2::Y, l2),
        DVec2::new(l0 - l1, -l1) * 4.0,
        DVec2::new(l2, l1) * 4.0,
        DVec2::new(-l2, l0 - l2) * 4.0,
    ]
}

/// Returns the position at `l` for node positions `x`.
#[inline]
pub fn position(x: &[DVec3; 6], l: [f64; 3]) -> DVec3 {
    let [a, b, c, ab, bc, ca] = *x;
    let n = values(l);
    a * n[0] + b * n[1] + c * n[2] + ab * n[3] + bc * n[4] + ca * n[5]
}

/// Returns the derivatives of the position at `l` for node positions `x`.
#[inline]
pub fn tangents(x: &[DVec3; 6], l: [f64; 3]) -> [DVec3; 2] {
    let [a, b, c, ab, bc, ca] = *x;
    let d0 = a * (4.0 * l[0] - 1.0) + (ab * l[1] + ca * l[2]) * 4.0;
    let d1 = b * (4.0 * l[1] - 1.0) + (ab * l[0] + bc * l[2]) * 4.0;
    let d2 = c * (4.0 * l[2] - 1.0) + (bc * l[1] + ca * l[0]) * 4.0;
    [d1 - d0, d2 - d0]
}

/// Returns the second derivatives of the position in `l1 l1`, `l1 l2` and `l2 l2` for node positions `x`, constant on
/// the triangle.
#[inline]
pub fn second_derivatives(x: &[DVec3; 6]) -> [DVec3; 3] {
    let [a, b, c, ab, bc, ca] = *x;
    [(a + b - ab * 2.0) * 4.0, (a + bc - ab - ca) * 4.0, (a + c - ca * 2.0) * 4.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A field of second degree in `l1` and `l2` is interpolated exactly, with its derivatives.
    #[test]
    fn a_quadratic_field_and_its_derivatives_are_reproduced() {
        let field = |u: f64, v: f64| DVec3::new(1.0 + 2.0 * u - 3.0 * u * v, v * v - u * u, 0.5 * v + u * v);
        let x = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)].map(|(u, v)| field(u, v));
        let (u, v) = (0.2, 0.7);
        let l = [1.0 - u - v, u, v];
        let [du, dv] = [DVec3::new(2.0 - 3.0 * v, -2.0 * u, v), DVec3::new(-3.0 * u, 2.0 * v, 0.5 + u)];
        let second = [DVec3::new(0.0, -2.0, 0.0), DVec3::new(-3.0, 0.0, 1.0), DVec3::new(0.0, 2.0, 0.0)];
        let near = |a: DVec3, b: DVec3| assert!(a.distance(b) < 1e-14, "{a} instead of {b}");
        near(position(&x, l), field(u, v));
        let slopes = derivatives(l);
        near(x.iter().zip(slopes).map(|(x, d)| *x * d.x).sum(), du);
        near(x.iter().zip(slopes).map(|(x, d)| *x * d.y).sum(), dv);
        tangents(&x, l).into_iter().zip([du, dv]).for_each(|(a, b)| near(a, b));
        second_derivatives(&x).into_iter().zip(second).for_each(|(a, b)| near(a, b));
    }
}
