//! Elastic energy, nodal forces and stiffness of one element.

use super::{RestTet, Shape};
use crate::material::{Dilatation, Material, cauchy, cofactor};
use glam::{DMat3, DVec3};

/// The elastic kernel of a tetrahedron with `N` nodes and `Q` quadrature points.
///
/// With `mean_dilatation` the volumetric energy is `V U(mean theta)`: one pressure per element
/// (Simo, Taylor & Pister 1985, equation 3.13), plus a small resistance to fluctuations around the mean. Without it each
/// point carries its own pressure, which locks near nu = 0.5.
pub struct Kernel<'a, const N: usize, const Q: usize> {
    /// Shape functions and quadrature.
    pub shape: &'a Shape<N, Q>,
    /// The law of the gel.
    pub material: &'a dyn Material,
    /// Average the dilatation over the element.
    pub mean_dilatation: bool,
}

impl<const N: usize, const Q: usize> Kernel<'_, N, Q> {
    /// Deformation gradients at the quadrature points from the current node positions `x`, m.
    #[inline(always)]
    pub fn deformation(&self, rest: &RestTet, x: &[DVec3; N]) -> [DMat3; Q] {
        let mut f = [DMat3::ZERO; Q];
        for q in 0..Q {
            let mut y = [DVec3::ZERO; 4];
            for a in 0..N {
                for k in 0..4 {
                    y[k] += x[a] * self.shape.d[q][a][k];
                }
            }
            for k in 0..4 {
                let g = rest.gradient[k];
                f[q] += DMat3::from_cols(y[k] * g.x, y[k] * g.y, y[k] * g.z);
            }
        }
        f
    }

    /// Dilatation at each point and their mean.
    #[inline(always)]
    fn dilatations(&self, f: &[DMat3; Q]) -> ([f64; Q], f64) {
        let kind = self.material.dilatation();
        let theta: [f64; Q] = std::array::from_fn(|q| kind.value(&f[q]));
        (theta, theta.iter().sum::<f64>() / Q as f64)
    }

    /// Modulus that resists fluctuations of the dilatation inside an element, Pa.
    ///
    /// Pure mean dilatation leaves them free, and the gel under a contact is then 1 to 2 % too soft; with the full bulk
    /// modulus it locks. The shear modulus, the stiffness of everything else in the element, does neither.
    fn fluctuation_modulus(&self) -> f64 {
        self.material.moduli().mu
    }

    /// Volumetric energy density, pressure and modulus at a point.
    #[inline(always)]
    fn volumetric(&self, theta: f64, mean: f64) -> [f64; 3] {
        if !self.mean_dilatation || Q == 1 {
            return self.material.volumetric(theta);
        }
        let [u, p, bulk] = self.material.volumetric(mean);
        let s = self.fluctuation_modulus().min(bulk);
        let d = theta - mean;
        [u + 0.5 * s * d * d, p + s * d, s]
    }

    /// Elastic energy, J; `+inf` where the law is not defined.
    #[inline]
    pub fn energy(&self, rest: &RestTet, x: &[DVec3; N]) -> f64 {
        let f = self.deformation(rest, x);
        let (theta, mean) = self.dilatations(&f);
        let density: f64 =
            (0..Q).map(|q| self.material.distortional_energy(&f[q]) + self.volumetric(theta[q], mean)[0]).sum();
        density * rest.volume / Q as f64
    }

    /// Adds the energy gradient (minus the elastic nodal force), N, to `gradient`.
    #[inline]
    pub fn add_gradient(&self, rest: &RestTet, x: &[DVec3; N], gradient: &mut [DVec3; N]) {
        let f = self.deformation(rest, x);
        let (theta, mean) = self.dilatations(&f);
        let kind = self.material.dilatation();
        let weight = rest.volume / Q as f64;
        for q in 0..Q {
            let pressure = self.volumetric(theta[q], mean)[1];
            let p = self.material.distortional_stress(&f[q]) + kind.gradient(&f[q]) * pressure;
            let t: [DVec3; 4] = std::array::from_fn(|k| p * rest.gradient[k] * weight);
            for a in 0..N {
                for k in 0..4 {
                    gradient[a] += t[k] * self.shape.d[q][a][k];
                }
            }
        }
    }

    /// Adds the energy gradient (N) and writes the stiffness (N/m): `stiffness[a][b]` is the block of nodes a and b,
    /// filled for `b >= a`. With `project`, every point's tangent is made positive semidefinite first.
    pub fn stiffness(
        &self,
        rest: &RestTet,
        x: &[DVec3; N],
        project: bool,
        gradient: &mut [DVec3; N],
        stiffness: &mut [[DMat3; N]; N],
    ) {
        let f = self.deformation(rest, x);
        let (theta, mean) = self.dilatations(&f);
        let kind = self.material.dilatation();
        let weight = rest.volume / Q as f64;
        let mut average = [DVec3::ZERO; N];
        for row in stiffness.iter_mut() {
            row.fill(DMat3::ZERO);
        }
        for q in 0..Q {
            let [_, pressure, bulk] = self.volumetric(theta[q], mean);
            let dtheta = kind.gradient(&f[q]);
            let p = self.material.distortional_stress(&f[q]) + dtheta * pressure;
            let mut tangent = self.material.distortional_tangent(&f[q]);
            kind.add_hessian(&f[q], pressure, &mut tangent);
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
            let d = &self.shape.d[q];
            // Contract with the four barycentric gradients: m[k][l] = g_k . tangent . g_l, blocks of 3 x 3.
            let m = contract(&tangent, &rest.gradient, weight);
            let t: [DVec3; 4] = std::array::from_fn(|k| p * rest.gradient[k] * weight);
            let v: [DVec3; 4] = std::array::from_fn(|k| dtheta * rest.gradient[k]);
            for a in 0..N {
                for k in 0..4 {
                    if d[a][k] != 0.0 {
                        gradient[a] += t[k] * d[a][k];
                        average[a] += v[k] * (d[a][k] / Q as f64);
                    }
                }
                for b in a..N {
                    for k in 0..4 {
                        if d[a][k] == 0.0 {
                            continue;
                        }
                        for l in 0..4 {
                            if d[b][l] != 0.0 {
                                stiffness[a][b] += m[k][l] * (d[a][k] * d[b][l]);
                            }
                        }
                    }
                }
            }
        }
        if self.mean_dilatation && Q > 1 {
            let bulk = self.material.volumetric(mean)[2];
            let bulk = (bulk - self.fluctuation_modulus().min(bulk)) * rest.volume;
            for a in 0..N {
                for b in a..N {
                    let w = average[b] * bulk;
                    let v = average[a];
                    stiffness[a][b] += DMat3::from_cols(v * w.x, v * w.y, v * w.z);
                }
            }
        }
    }

    /// Smallest determinant of the deformation gradient among the quadrature points of some elements, with node positions
    /// `x(element, node)`, m; element by element the same operations, side by side.
    #[inline(always)]
    pub fn min_det_f(&self, rest: &[RestTet], x: impl Fn(usize, usize) -> DVec3) -> f64 {
        const SIDE: usize = 8;
        let mut least = [f64::INFINITY; SIDE];
        for start in (0..rest.len()).step_by(SIDE) {
            // The last ones stand in for those that a whole row lacks.
            let own: [usize; SIDE] = std::array::from_fn(|l| (start + l).min(rest.len() - 1));
            let (mut at, mut g) = ([[[0.0; SIDE]; 3]; N], [[[0.0; SIDE]; 3]; 4]);
            for (l, e) in own.into_iter().enumerate() {
                for a in 0..N {
                    let x = x(e, a);
                    (0..3).for_each(|c| at[a][c][l] = x[c]);
                }
                for k in 0..4 {
                    (0..3).for_each(|c| g[k][c][l] = rest[e].gradient[k][c]);
                }
            }
            for d in &self.shape.d {
                let mut f = [[[0.0; SIDE]; 3]; 3];
                for k in 0..4 {
                    let mut y = [[0.0; SIDE]; 3];
                    for a in (0..N).filter(|a| d[*a][k] != 0.0) {
                        for c in 0..3 {
                            for l in 0..SIDE {
                                y[c][l] += at[a][c][l] * d[a][k];
                            }
                        }
                    }
                    for c in 0..3 {
                        for j in 0..3 {
                            for l in 0..SIDE {
                                f[j][c][l] += y[c][l] * g[k][j][l];
                            }
                        }
                    }
                }
                for l in 0..SIDE {
                    let minor = |a: usize, b: usize| f[1][a][l] * f[2][b][l] - f[1][b][l] * f[2][a][l];
                    let det = f[0][0][l] * minor(1, 2) - f[0][1][l] * minor(0, 2) + f[0][2][l] * minor(0, 1);
                    least[l] = least[l].min(det);
                }
            }
        }
        least.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Cauchy stress at the quadrature points, Pa.
    pub fn stress(&self, rest: &RestTet, x: &[DVec3; N]) -> [DMat3; Q] {
        let f = self.deformation(rest, x);
        let (theta, mean) = self.dilatations(&f);
        let kind = self.material.dilatation();
        std::array::from_fn(|q| {
            let pressure = self.volumetric(theta[q], mean)[1];
            let distortional = self.material.distortional_stress(&f[q]);
            match kind {
                // Exact for a pressure: cof(F) F^T / J = I, also where the mean pressure is taken.
                Dilatation::Determinant => cauchy(&(distortional + cofactor(&f[q]) * pressure), &f[q]),
                // Infinitesimal strain does not tell P from sigma.
                Dilatation::Trace => distortional + DMat3::IDENTITY * pressure,
            }
        })
    }
}

/// `m[k][l]_ij = weight * g_k[J] tangent[iJ][jL] g_l[L]`.
#[inline(always)]
fn contract(tangent: &[[f64; 9]; 9], g: &[DVec3; 4], weight: f64) -> [[DMat3; 4]; 4] {
    let g = g.map(|v| v.to_array());
    let mut m = [[DMat3::ZERO; 4]; 4];
    for k in 0..4 {
        // rows: half[i][jL]
        let mut half = [[0.0; 9]; 3];
        for i in 0..3 {
            for c in 0..9 {
                half[i][c] =
                    weight * (g[k][0] * tangent[i][c] + g[k][1] * tangent[3 + i][c] + g[k][2] * tangent[6 + i][c]);
            }
        }
        for l in 0..4 {
            let entry = |i: usize, j: usize| half[i][j] * g[l][0] + half[i][3 + j] * g[l][1] + half[i][6 + j] * g[l][2];
            m[k][l] = DMat3::from_cols_array(&[
                entry(0, 0),
                entry(1, 0),
                entry(2, 0),
                entry(0, 1),
                entry(1, 1),
                entry(2, 1),
                entry(0, 2),
                entry(1, 2),
                entry(2, 2),
            ]);
        }
    }
    m
}

/// Clamps the negative eigenvalues of a symmetric 9 x 9 tangent to zero (Teran et al. 2005).
fn project_positive(tangent: &mut [[f64; 9]; 9]) {
    let matrix = faer::Mat::<f64>::from_fn(9, 9, |i, j| 0.5 * (tangent[i][j] + tangent[j][i]));
    // The decomposition fails only for non-finite input, which no feasible state produces; keep the tangent then.
    let Ok(eigen) = matrix.self_adjoint_eigen(faer::Side::Lower) else { return };
    let (u, s) = (eigen.U(), eigen.S());
    for i in 0..9 {
        for j in 0..9 {
            tangent[i][j] = (0..9).map(|k| u[(i, k)] * s[k].max(0.0) * u[(j, k)]).sum();
        }
    }
}
