//! Shape functions of the 4-node and the 10-node tetrahedron on barycentric coordinates.

/// Shape functions of a tetrahedron with `N` nodes at `Q` quadrature points of equal weight.
#[derive(Debug, Clone, Copy)]
pub struct ShapeFunctions<const N: usize, const Q: usize> {
    /// Barycentric coordinates of the quadrature points.
    pub points: [[f64; 4]; Q],
    /// Derivatives `d[q][a][k]` of shape function `a` in barycentric coordinate `k` at point `q`.
    pub d: [[[f64; 4]; N]; Q],
}

/// The linear tetrahedron, one point: constant strain.
pub const TET4: ShapeFunctions<4, 1> = ShapeFunctions {
    points: [[0.25; 4]],
    d: [[[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]],
};

/// Corner pairs of the six mid-edge nodes 4..10, the order of VTK and CalculiX.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

/// The 10-node tetrahedron with the 4-point rule of degree 2 (Keast 1986).
pub const TET10: ShapeFunctions<10, 4> = tet10(keast());

/// The 10-node tetrahedron evaluated at its nodes, which are not quadrature points.
pub const TET10_NODES: ShapeFunctions<10, 10> = tet10(nodes());

/// The 10-node tetrahedron evaluated at its centre.
pub const TET10_CENTER: ShapeFunctions<10, 1> = tet10([[0.25; 4]]);

const fn keast() -> [[f64; 4]; 4] {
    // a = (5 + 3 sqrt 5) / 20, b = (5 - sqrt 5) / 20
    let (a, b) = (0.585_410_196_624_968_5, 0.138_196_601_125_010_5);
    [[a, b, b, b], [b, a, b, b], [b, b, a, b], [b, b, b, a]]
}

const fn nodes() -> [[f64; 4]; 10] {
    let mut points = [[0.0; 4]; 10];
    let mut k = 0;
    while k < 4 {
        points[k][k] = 1.0;
        k += 1;
    }
    let mut e = 0;
    while e < 6 {
        let [i, j] = EDGES[e];
        (points[4 + e][i], points[4 + e][j]) = (0.5, 0.5);
        e += 1;
    }
    points
}

/// Values of the shape functions of the 10-node tetrahedron at barycentric coordinates `l`: corners, then the midpoints
/// of [`EDGES`].
pub fn tet10_values(l: [f64; 4]) -> [f64; 10] {
    std::array::from_fn(|a| match a {
        0..4 => l[a] * (2.0 * l[a] - 1.0),
        _ => EDGES[a - 4].iter().map(|&k| l[k]).product::<f64>() * 4.0,
    })
}

const fn tet10<const Q: usize>(points: [[f64; 4]; Q]) -> ShapeFunctions<10, Q> {
    let mut d = [[[0.0; 4]; 10]; Q];
    let mut q = 0;
    while q < Q {
        let mut k = 0;
        while k < 4 {
            d[q][k][k] = 4.0 * points[q][k] - 1.0;
            k += 1;
        }
        let mut e = 0;
        while e < 6 {
            let [i, j] = EDGES[e];
            d[q][4 + e][i] = 4.0 * points[q][j];
            d[q][4 + e][j] = 4.0 * points[q][i];
            e += 1;
        }
        q += 1;
    }
    ShapeFunctions { points, d }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadratic_shape_functions_reproduce_quadratic_fields() {
        // f(l) = sum c_ij l_i l_j: the derivative of the nodal interpolation is exact along the simplex.
        let f = |l: [f64; 4]| 1.3 * l[0] * l[0] - 0.7 * l[1] * l[2] + 0.4 * l[3] * l[3] + 2.0 * l[0] * l[3] + l[2];
        let mut nodes = [[0.0; 4]; 10];
        for k in 0..4 {
            nodes[k][k] = 1.0;
        }
        for (e, [i, j]) in EDGES.into_iter().enumerate() {
            nodes[4 + e][i] = 0.5;
            nodes[4 + e][j] = 0.5;
        }
        for q in 0..4 {
            for k in 1..4 {
                let interpolated: f64 = (0..10).map(|a| f(nodes[a]) * (TET10.d[q][a][k] - TET10.d[q][a][0])).sum();
                let (mut p, mut m) = (TET10.points[q], TET10.points[q]);
                p[k] += 1e-6;
                p[0] -= 1e-6;
                m[k] -= 1e-6;
                m[0] += 1e-6;
                let exact = (f(p) - f(m)) / 2e-6;
                assert!(
                    (interpolated - exact).abs() < 1e-8,
                    "point {q}, direction {k}: {interpolated} against {exact}"
                );
            }
        }
    }
}
