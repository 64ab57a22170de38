//! Fixed corotated law: linear elasticity in the rotated frame of the material, cheap and defined for inverted
//! elements.

use super::{Dilatation, Material, Moduli, Tangent, quadratic};
use glam::{DMat3, DVec3};
use glamx::DSymmetricEigen3;

/// Law with the energy `W = mu |F - R|^2 + lambda/2 (J - 1)^2`, with the rotation `R` of the polar decomposition of `F`
/// (Stomakhin, Howes, Schroeder & Teran 2012, equation 6).
#[derive(Debug, Clone, Copy)]
pub struct FixedCorotated(Moduli);

impl FixedCorotated {
    /// Creates the law from Young's modulus (Pa) and Poisson's ratio of the undeformed material.
    pub fn new(young: f64, poisson: f64) -> Self {
        Self(Moduli::new(young, poisson))
    }
}

/// Rotation `R` and symmetric `S` with `F = R S`; `R` is a proper rotation also for inverted `F`, where the smallest
/// principal stretch is negative (Irving, Teran & Fedkiw 2004, section 4).
fn polar(f: &DMat3) -> (DMat3, DMat3) {
    let eigen = DSymmetricEigen3::new(f.transpose() * *f);
    let v = [eigen.eigenvectors.x_axis, eigen.eigenvectors.y_axis, eigen.eigenvectors.z_axis];
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let [a, b] = [v[order[0]].normalize(), v[order[1]].normalize()];
    let c = a.cross(b);
    // The two largest stretches give two axes, and these the third, so that a flat or inverted F is not a special case.
    let u = (*f * a).try_normalize().unwrap_or(DVec3::X);
    let w = *f * b;
    let w = (w - u * u.dot(w)).try_normalize().unwrap_or_else(|| u.any_orthonormal_vector());
    let r = DMat3::from_cols(u, w, u.cross(w)) * DMat3::from_cols(a, b, c).transpose();
    let s = r.transpose() * *f;
    (r, (s + s.transpose()) * 0.5)
}

impl Material for FixedCorotated {
    fn name(&self) -> &'static str {
        "corotated"
    }

    fn dilatation(&self) -> Dilatation {
        Dilatation::Determinant
    }

    fn distortional_energy(&self, f: &DMat3) -> f64 {
        let d = *f - polar(f).0;
        self.0.mu * (d.x_axis.length_squared() + d.y_axis.length_squared() + d.z_axis.length_squared())
    }

    fn distortional_stress(&self, f: &DMat3) -> DMat3 {
        (*f - polar(f).0) * (2.0 * self.0.mu)
    }

    fn distortional_tangent(&self, f: &DMat3) -> Tangent {
        // dR = R [w]x with (tr(S) I - S) w = axial(R^T dF - dF^T R) (McAdams et al. 2011).
        let (r, s) = polar(f);
        let trace = s.x_axis.x + s.y_axis.y + s.z_axis.z;
        let g = DMat3::from_diagonal(DVec3::splat(trace)) - s;
        // Near-singular only when two principal stretches sum to zero (deep inversion): then R is not differentiable.
        let floor = 1e-6;
        let g = if g.determinant().abs() < floor { g + DMat3::from_diagonal(DVec3::splat(floor)) } else { g };
        let g_inv = g.inverse();
        let mut t = [[0.0; 9]; 9];
        for b in 0..9 {
            let mut df = [0.0; 9];
            df[b] = 1.0;
            let df = DMat3::from_cols_array(&df);
            let k = r.transpose() * df;
            let axial = DVec3::new(k.y_axis.z - k.z_axis.y, k.z_axis.x - k.x_axis.z, k.x_axis.y - k.y_axis.x);
            let w = g_inv * axial;
            let cross =
                DMat3::from_cols(DVec3::new(0.0, w.z, -w.y), DVec3::new(-w.z, 0.0, w.x), DVec3::new(w.y, -w.x, 0.0));
            let column = ((df - r * cross) * (2.0 * self.0.mu)).to_cols_array();
            for a in 0..9 {
                t[a][b] = column[a];
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
