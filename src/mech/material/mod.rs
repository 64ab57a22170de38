//! Constitutive laws of the gel: one law per file behind the [`Material`] trait.
//!
//! A law is split into a *distortional* part, evaluated point by point, and a *volumetric* energy of one scalar, the
//! dilatation. The split allows an element to average the dilatation (mean dilatation, Nagtegaal, Parks & Rice 1974;
//! Simo, Taylor & Pister 1985) with any law, so that nearly incompressible gels do not lock.
//!
//! Adding a law takes one file that implements [`Material`], one line here and one line in the derivative test.

mod corotated;
mod linear;
mod neo_hookean;
pub mod preset;

pub use corotated::FixedCorotated;
pub use linear::Linear;
pub use neo_hookean::NeoHookean;

use glam::{DMat3, DVec3};

/// Fourth-order tangent dP/dF, Pa: `t[3*J+i][3*L+j] = dP_iJ / dF_jL` (columns of F one after the other).
pub type Tangent = [[f64; 9]; 9];

/// Scalar by which a law measures the change of volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dilatation {
    /// Dilatation `theta = det F - 1`, for laws of finite strain.
    Determinant,
    /// Dilatation `theta = tr F - 3`, for laws of infinitesimal strain.
    Trace,
}

impl Dilatation {
    /// Dilatation of the deformation gradient `f`, dimensionless, 0 without deformation.
    #[inline(always)]
    pub fn value(self, f: &DMat3) -> f64 {
        match self {
            Dilatation::Determinant => f.determinant() - 1.0,
            Dilatation::Trace => f.x_axis.x + f.y_axis.y + f.z_axis.z - 3.0,
        }
    }

    /// Gradient d theta / dF: the cofactor matrix, or the identity.
    #[inline(always)]
    pub fn gradient(self, f: &DMat3) -> DMat3 {
        match self {
            Dilatation::Determinant => cofactor(f),
            Dilatation::Trace => DMat3::IDENTITY,
        }
    }

    /// Adds `scale * d2 theta / dF2` to a tangent.
    #[inline(always)]
    pub fn add_hessian(self, f: &DMat3, scale: f64, t: &mut Tangent) {
        if self == Dilatation::Determinant {
            // d cof(F) / dF: block (J, L) is the cross matrix of the third column.
            let columns = [f.x_axis * scale, f.y_axis * scale, f.z_axis * scale];
            for (j, l, m, sign) in
                [(0, 1, 2, -1.0), (1, 0, 2, 1.0), (1, 2, 0, -1.0), (2, 1, 0, 1.0), (2, 0, 1, -1.0), (0, 2, 1, 1.0)]
            {
                let c = columns[m] * sign;
                // Matrix of v -> c x v, rows i, columns j.
                t[3 * j][3 * l + 1] -= c.z;
                t[3 * j][3 * l + 2] += c.y;
                t[3 * j + 1][3 * l] += c.z;
                t[3 * j + 1][3 * l + 2] -= c.x;
                t[3 * j + 2][3 * l] -= c.y;
                t[3 * j + 2][3 * l + 1] += c.x;
            }
        }
    }
}

/// A hyperelastic law, in the form `W(F) = W_d(F) + U(theta(F))`.
pub trait Material: Send + Sync + std::fmt::Debug {
    /// Name as it appears in scenes and reports.
    fn name(&self) -> &'static str;
    /// Dilatation that is the argument of [`Material::volumetric`].
    fn dilatation(&self) -> Dilatation;
    /// Distortional energy density, J/m3; `+inf` where the law is not defined (an inverted element).
    fn distortional_energy(&self, f: &DMat3) -> f64;
    /// Derivative dW_d/dF of that energy, the distortional first Piola-Kirchhoff stress, Pa.
    fn distortional_stress(&self, f: &DMat3) -> DMat3;
    /// Second derivative of that energy, Pa.
    fn distortional_tangent(&self, f: &DMat3) -> Tangent;
    /// Volumetric energy density and its first two derivatives in the dilatation `theta`: `[J/m3, Pa, Pa]`.
    fn volumetric(&self, theta: f64) -> [f64; 3];
    /// Elastic constants of the undeformed material: they scale contact stiffness and tolerances.
    fn moduli(&self) -> &Moduli;
}

/// Elastic constants of an undeformed isotropic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moduli {
    /// Young's modulus, Pa.
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Shear modulus, Pa.
    pub mu: f64,
    /// Bulk modulus, Pa.
    pub kappa: f64,
    /// Lame's first constant, Pa.
    pub lambda: f64,
}

impl Moduli {
    /// Computes the constants from Young's modulus (Pa) and Poisson's ratio.
    pub fn new(young: f64, poisson: f64) -> Self {
        let (mu, kappa) = (young / (2.0 * (1.0 + poisson)), young / (3.0 * (1.0 - 2.0 * poisson)));
        Self { young, poisson, mu, kappa, lambda: kappa - 2.0 / 3.0 * mu }
    }
}

/// The volumetric energy `modulus / 2 theta^2` with its derivatives, as [`Material::volumetric`] returns them.
#[inline(always)]
fn quadratic(modulus: f64, theta: f64) -> [f64; 3] {
    [0.5 * modulus * theta * theta, modulus * theta, modulus]
}

/// Cofactor matrix `det(F) F^-T`, also defined for singular F.
#[inline(always)]
pub fn cofactor(f: &DMat3) -> DMat3 {
    DMat3::from_cols(f.y_axis.cross(f.z_axis), f.z_axis.cross(f.x_axis), f.x_axis.cross(f.y_axis))
}

/// Cauchy stress from the first Piola-Kirchhoff stress, `P F^T / J`, Pa.
pub fn cauchy(p: &DMat3, f: &DMat3) -> DMat3 {
    *p * f.transpose() * (1.0 / f.determinant())
}

/// Von Mises equivalent of a symmetric stress tensor, Pa.
pub fn von_mises(s: &DMat3) -> f64 {
    let (a, b, c) = (s.x_axis.x, s.y_axis.y, s.z_axis.z);
    let shear = DVec3::new(s.x_axis.y, s.y_axis.z, s.z_axis.x).length_squared();
    (0.5 * ((a - b).powi(2) + (b - c).powi(2) + (c - a).powi(2)) + 3.0 * shear).sqrt()
}
