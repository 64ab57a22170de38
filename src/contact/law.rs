//! The contact law at one point, per unit area: normal pressure and Coulomb friction by the augmented Lagrangian
//! (Alart & Curnier 1991; Simo & Laursen 1992), each the gradient of a C1 potential.
//!
//! Against a barrier, whose Newton iterations shrink their step to the first point that would touch, the augmented
//! Lagrangian may overshoot between accepted states and so changes the contact set everywhere at once. The multiplier
//! carries the pressure, the stiffness only the change since the last accepted state, so that gaps stay at `offset` (a
//! micrometre) whatever the load, and no accepted state penetrates.

use glam::DVec3;

/// Constants of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// Stiffness per area in normal direction, Pa/m.
    pub stiffness: f64,
    /// Gap at which the surfaces meet, m: all contact happens this far outside the true surface.
    pub offset: f64,
    /// Coulomb coefficient; 0 switches friction off.
    pub friction: f64,
    /// Stiffness per area in tangential direction, Pa/m.
    pub tangential: f64,
}

impl Law {
    /// Pressure at a gap with multiplier `lambda` (Pa), Pa, never negative.
    #[inline(always)]
    pub fn pressure(&self, gap: f64, lambda: f64) -> f64 {
        (lambda + self.stiffness * (self.offset - gap)).max(0.0)
    }

    /// Energy per area, J/m2; its derivative in the gap is minus [`Law::pressure`].
    #[inline(always)]
    pub fn normal_energy(&self, gap: f64, lambda: f64) -> f64 {
        let p = self.pressure(gap, lambda);
        (p * p - lambda * lambda) / (2.0 * self.stiffness)
    }

    /// Gap beyond which the pressure is zero, m.
    #[inline(always)]
    pub fn reach(&self, lambda: f64) -> f64 {
        self.offset + lambda / self.stiffness
    }

    /// Friction traction (Pa) at tangential slip `s` (m) with multiplier `lambda` (Pa) and limit `limit = mu p` (Pa), and
    /// whether it slips. The traction opposes the slip.
    #[inline(always)]
    pub fn traction(&self, s: DVec3, lambda: DVec3, limit: f64) -> (DVec3, bool) {
        let trial = lambda - s * self.tangential;
        let size = trial.length();
        if size > limit { (trial * (limit / size), true) } else { (trial, false) }
    }

    /// Friction energy per area, J/m2, at frozen `limit`; its gradient in `s` is minus the traction.
    #[inline(always)]
    pub fn friction_energy(&self, s: DVec3, lambda: DVec3, limit: f64) -> f64 {
        let size = (lambda - s * self.tangential).length();
        let huber = if size > limit { limit * (size - 0.5 * limit) } else { 0.5 * size * size };
        (huber - 0.5 * lambda.length_squared()) / self.tangential
    }

    /// Coefficients `(a, b)` of the friction Hessian `a (I - n n^T) - b t t^T`, Pa/m, with `t` the unit traction.
    #[inline(always)]
    pub fn friction_hessian(&self, s: DVec3, lambda: DVec3, limit: f64) -> (f64, f64) {
        let size = (lambda - s * self.tangential).length();
        if size > limit {
            let a = self.tangential * limit / size;
            (a, a)
        } else {
            (self.tangential, 0.0)
        }
    }
}
