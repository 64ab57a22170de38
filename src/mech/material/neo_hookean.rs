//! Compressible neo-Hookean law with decoupled volumetric energy: the law of the gel.

use super::{Dilatation, Material, Moduli, Tangent, cofactor, quadratic};
use glam::DMat3;

/// Law with the energy `W = mu/2 (J^(-2/3) tr(F^T F) - 3) + kappa/2 (J - 1)^2` (Bonet & Wood 2008, section 6.5.1) and
/// the stress `sigma = mu/J dev(J^(-2/3) F F^T) + kappa (J - 1) I`. The energy is infinite for `J <= 0`, so that a line
/// search rejects inversion.
#[derive(Debug, Clone, Copy)]
pub struct NeoHookean(Moduli);

impl NeoHookean {
    /// Creates the law from Young's modulus (Pa) and Poisson's ratio of the undeformed material.
    pub fn new(young: f64, poisson: f64) -> Self {
        Self(Moduli::new(young, poisson))
    }

    /// Creates the law from the Mooney coefficient `C10 = mu/2` (Pa) and Poisson's ratio.
    pub fn from_c10(c10: f64, poisson: f64) -> Self {
        Self::new(4.0 * c10 * (1.0 + poisson), poisson)
    }
}

impl Material for NeoHookean {
    fn name(&self) -> &'static str {
        "neo-Hookean"
    }

    fn dilatation(&self) -> Dilatation {
        Dilatation::Determinant
    }

    #[inline]
    fn distortional_energy(&self, f: &DMat3) -> f64 {
        let j = f.determinant();
        if j <= 0.0 {
            return f64::INFINITY;
        }
        // I1 - 3 from the displacement gradient H = F - I is accurate at small strains: tr(F^T F) - 3 = 2 tr H + |H|^2,
        // and J^(-2/3) = exp(-2/3 ln J).
        let h = *f - DMat3::IDENTITY;
        let trace = h.x_axis.x + h.y_axis.y + h.z_axis.z;
        let squared = h.x_axis.length_squared() + h.y_axis.length_squared() + h.z_axis.length_squared();
        let i1_minus_3 = 2.0 * trace + squared;
        let minors = {
            let c = cofactor(&h);
            c.x_axis.x + c.y_axis.y + c.z_axis.z
        };
        let j_minus_1 = trace + minors + h.determinant();
        let factor_minus_1 = (-2.0 / 3.0 * j_minus_1.ln_1p()).exp_m1();
        0.5 * self.0.mu * (i1_minus_3 + factor_minus_1 * (i1_minus_3 + 3.0))
    }

    #[inline]
    fn distortional_stress(&self, f: &DMat3) -> DMat3 {
        let j = f.determinant();
        let i1 = f.x_axis.length_squared() + f.y_axis.length_squared() + f.z_axis.length_squared();
        (*f - cofactor(f) * (i1 / (3.0 * j))) * (self.0.mu * j.powf(-2.0 / 3.0))
    }

    #[inline]
    fn distortional_tangent(&self, f: &DMat3) -> Tangent {
        let j = f.determinant();
        let i1 = f.x_axis.length_squared() + f.y_axis.length_squared() + f.z_axis.length_squared();
        let m = self.0.mu * j.powf(-2.0 / 3.0);
        let g = (cofactor(f) * (1.0 / j)).to_cols_array(); // F^-T
        let f = f.to_cols_array();
        // With G = F^-T: dP = m [ dF - 2/3 (G:dF) F - 2/3 (F:dF) G + 2/9 I1 (G:dF) G + I1/3 G dF^T G ].
        let c = 2.0 / 9.0 * i1;
        let mut t = [[0.0; 9]; 9];
        for a in 0..9 {
            for b in 0..9 {
                // (G dF^T G)_iJ = G_iL dF_jL G_jJ
                let (i, jj, k, l) = (a % 3, a / 3, b % 3, b / 3);
                t[a][b] = m
                    * (g[a] * (c * g[b] - 2.0 / 3.0 * f[b]) - 2.0 / 3.0 * f[a] * g[b]
                        + i1 / 3.0 * g[3 * l + i] * g[3 * jj + k]);
            }
            t[a][a] += m;
        }
        t
    }

    #[inline]
    fn volumetric(&self, theta: f64) -> [f64; 3] {
        quadratic(self.0.kappa, theta)
    }

    fn moduli(&self) -> &Moduli {
        &self.0
    }
}
