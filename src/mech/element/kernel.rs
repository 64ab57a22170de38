//! Elastic energy, nodal forces and stiffness of one element.

use super::{RestTet, ShapeFunctions};
use crate::material::{Dilatation, Material, cauchy, cofactor};
use glam::{DMat3, DVec3};

/// Elastic kernel of a tetrahedron with `N` nodes and `Q` quadrature points.
///
/// The volumetric energy with `mean_dilatation` is `V U(mean theta)`: one pressure per element (Simo, Taylor & Pister
/// 1985, equation 3.13), plus a small resistance to fluctuations around the mean. Without it each point has its own
/// pressure, which locks near nu = 0.5.
pub struct Kernel<'a, const N: usize, const Q: usize> {
    /// Shape functions and quadrature.
    pub shape: &'a ShapeFunctions<N, Q>,
    /// Law of the gel.
    pub material: &'a dyn Material,
    /// Flag: the dilatation is averaged over the element.
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
    pub(crate) fn dilatations(&self, f: &[DMat3; Q]) -> ([f64; Q], f64) {
        let kind = self.material.dilatation();
        let theta: [f64; Q] = std::array::from_fn(|q| kind.value(&f[q]));
        (theta, theta.iter().sum::<f64>() / Q as f64)
    }

    /// Modulus that resists fluctuations of the dilatation inside an element, Pa.
    ///
    /// Pure mean dilatation does not resist them, so that the gel under a contact is 1 to 2 % too soft; with the full
    /// bulk modulus the element locks. The shear modulus, the stiffness of all other deformations of the element, does
    /// neither.
    pub(crate) fn fluctuation_modulus(&self) -> f64 {
        self.material.moduli().mu
    }

    /// Volumetric energy density, pressure and modulus at a point.
    #[inline(always)]
    pub(crate) fn volumetric(&self, theta: f64, mean: f64) -> [f64; 3] {
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

    /// Smallest determinant of the deformation gradient among the quadrature points of the given elements, with node
    /// positions `x(element, node)`, m. Elements are computed in vector lanes, with the same operations for each.
    #[inline(always)]
    pub fn min_det_f(&self, rest: &[RestTet], x: impl Fn(usize, usize) -> DVec3) -> f64 {
        const LANES: usize = 8;
        let mut least = [f64::INFINITY; LANES];
        for start in (0..rest.len()).step_by(LANES) {
            // The last element fills the unused lanes of the last batch.
            let own: [usize; LANES] = std::array::from_fn(|l| (start + l).min(rest.len() - 1));
            let (mut at, mut g) = ([[[0.0; LANES]; 3]; N], [[[0.0; LANES]; 3]; 4]);
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
                let mut f = [[[0.0; LANES]; 3]; 3];
                for k in 0..4 {
                    let mut y = [[0.0; LANES]; 3];
                    for a in (0..N).filter(|a| d[*a][k] != 0.0) {
                        for c in 0..3 {
                            for l in 0..LANES {
                                y[c][l] += at[a][c][l] * d[a][k];
                            }
                        }
                    }
                    for c in 0..3 {
                        for j in 0..3 {
                            for l in 0..LANES {
                                f[j][c][l] += y[c][l] * g[k][j][l];
                            }
                        }
                    }
                }
                for l in 0..LANES {
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
                // For infinitesimal strain, P and sigma coincide.
                Dilatation::Trace => distortional + DMat3::IDENTITY * pressure,
            }
        })
    }
}
