//! Linear elasticity of infinitesimal strain: the cheapest law, valid for small strains and small rotations only.

use super::{Dilatation, Material, Moduli, Tangent, quadratic};
use glam::DMat3;

/// Law with the energy `W = mu |e|^2 + lambda/2 (tr e)^2`, `e = sym(F - I)` (Hooke's law). It is defined for every F.
#[derive(Debug, Clone, Copy)]
pub struct Linear(Moduli);

impl Linear {
    /// Creates the law from Young's modulus (Pa) and Poisson's ratio.
    pub fn new(young: f64, poisson: f64) -> Self {
        Self(Moduli::new(young, poisson))
    }
}

impl Material for Linear {
    fn name(&self) -> &'static str {
        "linear"
    }

    fn dilatation(&self) -> Dilatation {
        Dilatation::Trace
    }

    fn distortional_energy(&self, f: &DMat3) -> f64 {
        let h = *f - DMat3::IDENTITY;
        let e = (h + h.transpose()) * 0.5;
        self.0.mu * (e.x_axis.length_squared() + e.y_axis.length_squared() + e.z_axis.length_squared())
    }

    fn distortional_stress(&self, f: &DMat3) -> DMat3 {
        let h = *f - DMat3::IDENTITY;
        (h + h.transpose()) * self.0.mu
    }

    fn distortional_tangent(&self, _: &DMat3) -> Tangent {
        let mut t = [[0.0; 9]; 9];
        for i in 0..3 {
            for j in 0..3 {
                t[3 * j + i][3 * j + i] += self.0.mu;
                t[3 * j + i][3 * i + j] += self.0.mu;
            }
        }
        t
    }

    fn volumetric(&self, theta: f64) -> [f64; 3] {
        quadratic(self.0.lambda, theta)
    }

    fn moduli(&self) -> &Moduli {
        &self.0
    }
}
