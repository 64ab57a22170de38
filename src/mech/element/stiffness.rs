//! Stiffness of several elements in vector lanes. Each element undergoes the same operations in the same order, so that
//! the result is bitwise independent of the number of elements.

use super::{Kernel, RestTet};
use crate::material::Tangent;
use glam::{DMat3, DVec3};

/// Entries of a 3 x 3 block, column by column, of each of `L` elements.
type Block<const L: usize> = [[f64; L]; 9];

/// Energy gradients (N per node) and stiffness (N/m) of `L` elements.
pub struct Stiffness<const N: usize, const L: usize> {
    /// Energy gradient per element and node, N.
    pub gradient: [[DVec3; N]; L],
    /// Blocks `[a][b]` of the nodes a and b, filled for `b >= a`.
    blocks: [[Block<L>; N]; N],
}

impl<const N: usize, const L: usize> Default for Stiffness<N, L> {
    fn default() -> Self {
        Self { gradient: [[DVec3::ZERO; N]; L], blocks: [[[[0.0; L]; 9]; N]; N] }
    }
}

impl<const N: usize, const L: usize> Stiffness<N, L> {
    /// Block of nodes `a` and `b >= a` of element `lane`.
    #[inline(always)]
    pub fn block(&self, lane: usize, a: usize, b: usize) -> DMat3 {
        DMat3::from_cols_array(&std::array::from_fn(|e| self.blocks[a][b][e][lane]))
    }
}

impl<const N: usize, const Q: usize> Kernel<'_, N, Q> {
    /// Computes gradients and stiffness of the elements with reference geometry `rest` and node positions `x` (m) and
    /// stores them in `sum`. If `project` is set, the tangent of every point is made positive semidefinite first.
    #[inline(always)]
    pub fn stiffness<const L: usize>(
        &self,
        rest: [&RestTet; L],
        x: &[[DVec3; N]; L],
        project: bool,
        sum: &mut Stiffness<N, L>,
    ) {
        let f: [[DMat3; Q]; L] = std::array::from_fn(|l| self.deformation(rest[l], &x[l]));
        let dilatations: [([f64; Q], f64); L] = std::array::from_fn(|l| self.dilatations(&f[l]));
        let weight: [f64; L] = std::array::from_fn(|l| rest[l].volume / Q as f64);
        // Barycentric gradients.
        let g: [[[f64; L]; 3]; 4] =
            std::array::from_fn(|k| std::array::from_fn(|c| std::array::from_fn(|l| rest[l].gradient[k][c])));
        let mut average = [[[0.0; L]; 3]; N];
        let mut m = [[[[[0.0; L]; 9]; 4]; 4]; Q];
        sum.gradient = [[DVec3::ZERO; N]; L];
        for q in 0..Q {
            let d = &self.shape.d[q];
            let mut tangents = [[[0.0; L]; 9]; 9];
            for l in 0..L {
                let (theta, mean) = (dilatations[l].0[q], dilatations[l].1);
                let (tangent, p, dtheta) = self.tangent(&f[l][q], self.volumetric(theta, mean), project);
                for a in 0..9 {
                    for b in 0..9 {
                        tangents[a][b][l] = tangent[a][b];
                    }
                }
                let t: [DVec3; 4] = std::array::from_fn(|k| p * rest[l].gradient[k] * weight[l]);
                let v: [DVec3; 4] = std::array::from_fn(|k| dtheta * rest[l].gradient[k]);
                for a in 0..N {
                    for k in (0..4).filter(|k| d[a][*k] != 0.0) {
                        sum.gradient[l][a] += t[k] * d[a][k];
                        let v = v[k] * (d[a][k] / Q as f64);
                        (0..3).for_each(|c| average[a][c][l] += v[c]);
                    }
                }
            }
            m[q] = contract(&tangents, &g, &weight);
        }
        let averaged = self.mean_dilatation && Q > 1;
        let bulk: [f64; L] = std::array::from_fn(|l| {
            let bulk = self.material.volumetric(dilatations[l].1)[2];
            (bulk - self.fluctuation_modulus().min(bulk)) * rest[l].volume
        });
        for a in 0..N {
            for b in a..N {
                // Accumulated in registers over all points.
                let mut block = [[0.0; L]; 9];
                for (m, d) in m.iter().zip(&self.shape.d) {
                    for k in (0..4).filter(|k| d[a][*k] != 0.0) {
                        for o in (0..4).filter(|o| d[b][*o] != 0.0) {
                            let factor = d[a][k] * d[b][o];
                            for e in 0..9 {
                                for l in 0..L {
                                    block[e][l] += m[k][o][e][l] * factor;
                                }
                            }
                        }
                    }
                }
                if averaged {
                    for e in 0..9 {
                        for l in 0..L {
                            block[e][l] += average[a][e % 3][l] * (average[b][e / 3][l] * bulk[l]);
                        }
                    }
                }
                sum.blocks[a][b] = block;
            }
        }
    }

    /// Tangent dP/dF, stress P and dtheta/dF at a point where the volumetric part has pressure and modulus
    /// `volumetric`.
    #[inline(always)]
    fn tangent(&self, f: &DMat3, volumetric: [f64; 3], project: bool) -> (Tangent, DMat3, DMat3) {
        let kind = self.material.dilatation();
        let [_, pressure, bulk] = volumetric;
        let dtheta = kind.gradient(f);
        let p = self.material.distortional_stress(f) + dtheta * pressure;
        let mut tangent = self.material.distortional_tangent(f);
        kind.add_hessian(f, pressure, &mut tangent);
        if bulk != 0.0 {
            let d = dtheta.to_cols_array();
            for a in 0..9 {
                for b in 0..9 {
                    tangent[a][b] += bulk * d[a] * d[b];
                }
            }
        }
        if project {
            project_positive(&mut tangent);
        }
        (tangent, p, dtheta)
    }
}

/// Computes `m[k][o]_ij = weight * g_k[J] tangent[iJ][jM] g_o[M]`.
#[inline(always)]
fn contract<const L: usize>(
    tangent: &[[[f64; L]; 9]; 9],
    g: &[[[f64; L]; 3]; 4],
    weight: &[f64; L],
) -> [[Block<L>; 4]; 4] {
    let mut m = [[[[0.0; L]; 9]; 4]; 4];
    for k in 0..4 {
        // rows: half[i][jM]
        let mut half = [[[0.0; L]; 9]; 3];
        for i in 0..3 {
            for c in 0..9 {
                for l in 0..L {
                    let t = |j: usize| g[k][j][l] * tangent[3 * j + i][c][l];
                    half[i][c][l] = weight[l] * (t(0) + t(1) + t(2));
                }
            }
        }
        for o in 0..4 {
            for e in 0..9 {
                let (i, j) = (e % 3, e / 3);
                for l in 0..L {
                    let h = |c: usize| half[i][3 * c + j][l] * g[o][c][l];
                    m[k][o][e][l] = h(0) + h(1) + h(2);
                }
            }
        }
    }
    m
}

/// Smallest eigenvalue of a projected tangent over its largest: with zero eigenvalues, rounding would decide whether a
/// sum of tangents is positive definite.
const SMALLEST_EIGENVALUE_RATIO: f64 = 1e-10;

/// Raises the negative eigenvalues of a symmetric 9 x 9 tangent to [`SMALLEST_EIGENVALUE_RATIO`] times the largest
/// (Teran et al. 2005: to zero).
fn project_positive(tangent: &mut [[f64; 9]; 9]) {
    let matrix = faer::Mat::<f64>::from_fn(9, 9, |i, j| 0.5 * (tangent[i][j] + tangent[j][i]));
    // The decomposition fails only for non-finite input, which no feasible state produces; keep the tangent then.
    let Ok(eigen) = matrix.self_adjoint_eigen(faer::Side::Lower) else { return };
    let (u, s) = (eigen.U(), eigen.S());
    let least = SMALLEST_EIGENVALUE_RATIO * (0..9).map(|k| s[k].abs()).fold(0.0, f64::max);
    for i in 0..9 {
        for j in 0..9 {
            tangent[i][j] = (0..9).map(|k| u[(i, k)] * s[k].max(least) * u[(j, k)]).sum();
        }
    }
}
