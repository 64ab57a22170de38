//! Determinant of the deformation gradient F of tetrahedra, from node positions alone, for the independent audit of
//! frames.

use glam::{DMat3, DVec3};
use record::{ElementNodes, PadTopology};

/// End nodes of the edges whose mid-edge nodes are 4 to 9.
pub(super) const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// Returns the smallest det F of a pad whose nodes are at `x`, m, with the reference positions of `topology`; a value
/// of 0 or less means an inverted element. A 4-node tetrahedron has one value; a 10-node one is evaluated at the
/// corners, the edge midpoints, the four points of the quadrature rule of degree 2 (Keast 1986) and the centre.
pub fn min_det_f(topology: &PadTopology, x: &[DVec3]) -> f64 {
    let rest = &topology.rest;
    match &topology.elements {
        ElementNodes::Linear(tets) => {
            let edges = |n: &[u32; 4], x: &[DVec3]| {
                let [a, b, c, d] = n.map(|i| x[i as usize]);
                DMat3::from_cols(b - a, c - a, d - a).determinant()
            };
            tets.iter().map(|n| edges(n, x) / edges(n, rest)).fold(f64::INFINITY, f64::min)
        }
        ElementNodes::Quadratic(tets) => {
            let points = points();
            let of = |n: &[u32; 10]| {
                let (x, rest) = (n.map(|i| x[i as usize]), n.map(|i| rest[i as usize]));
                let det = |l: &[f64; 4]| jacobian(&x, l).determinant() / jacobian(&rest, l).determinant();
                points.iter().map(det).fold(f64::INFINITY, f64::min)
            };
            tets.iter().map(of).fold(f64::INFINITY, f64::min)
        }
    }
}

/// Returns the barycentric coordinates at which a 10-node tetrahedron is evaluated.
fn points() -> Vec<[f64; 4]> {
    let mut points = vec![[0.25; 4]];
    for k in 0..4 {
        let mut corner = [0.0; 4];
        corner[k] = 1.0;
        let inner = (5.0 - 5.0_f64.sqrt()) / 20.0;
        let mut keast = [inner; 4];
        keast[k] = 1.0 - 3.0 * inner;
        points.extend([corner, keast]);
    }
    points.extend(EDGES.map(|ends| std::array::from_fn(|k| if ends.contains(&k) { 0.5 } else { 0.0 })));
    points
}

/// Computes the derivative of the position in a 10-node tetrahedron with node positions `x` (m) with respect to the
/// barycentric coordinates 1 to 3, at the barycentric coordinates `l`. Returns a matrix with one column per coordinate,
/// m; coordinate 0 is one minus their sum.
pub(crate) fn jacobian(x: &[DVec3; 10], l: &[f64; 4]) -> DMat3 {
    let mut d: [DVec3; 4] = std::array::from_fn(|k| x[k] * (4.0 * l[k] - 1.0));
    for (e, [i, j]) in EDGES.into_iter().enumerate() {
        d[i] += x[4 + e] * (4.0 * l[j]);
        d[j] += x[4 + e] * (4.0 * l[i]);
    }
    DMat3::from_cols(d[1] - d[0], d[2] - d[0], d[3] - d[0])
}

/// Computes the position of the point of a 10-node tetrahedron with node positions `x` (m) at the barycentric
/// coordinates `l`, m.
pub(crate) fn position(x: &[DVec3; 10], l: &[f64; 4]) -> DVec3 {
    let corners: DVec3 = (0..4).map(|k| x[k] * (l[k] * (2.0 * l[k] - 1.0))).sum();
    EDGES.into_iter().enumerate().fold(corners, |p, (e, [i, j])| p + x[4 + e] * (4.0 * l[i] * l[j]))
}
