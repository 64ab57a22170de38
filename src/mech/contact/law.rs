//! The contact law at one point, per unit area: normal pressure and Coulomb friction, each the gradient of a C1
//! potential.
//!
//! Surfaces come into contact at a gap `offset` (a 400th of the pad thickness). Below it a stiff penalty acts, which
//! becomes stiffer in the last quarter, so that accepted states do not penetrate while iterates may. Unlike a barrier,
//! whose steps are limited by the first point that would touch, this lets one Newton iteration change the contact set
//! everywhere; unlike an augmented Lagrangian it has no history, so that the solution does not depend on the number of
//! increments. Since travel counts from the contact of the offset surfaces, the offset acts as an equal increase of the
//! radius.

use super::coulomb::{cone_factor, slips};
use base::scales::CONTACT_STIFFNESS;
use glam::DVec3;

/// Constants of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLaw {
    /// Stiffness per area in normal direction, Pa/m.
    pub stiffness: f64,
    /// Gap at which surfaces come into contact, m.
    pub offset: f64,
    /// Coulomb coefficient; 0 disables friction.
    pub friction: f64,
    /// Stiffness per area in tangential direction while sticking, Pa/m.
    pub tangential: f64,
}

/// Fraction of the offset in which the stiffer branch acts.
const STIFFER_BRANCH: f64 = 0.25;
/// Reduced contact offset over the full one.
const REDUCED_OFFSET: f64 = 0.3;
/// Smallest gap of an accepted state, as a fraction of the offset.
const SMALLEST_GAP: f64 = 0.02;
/// Stiffness of the stiffer branch over that of the law.
const STIFFER_BRANCH_RATIO: f64 = 30.0;

impl ContactLaw {
    /// Creates the law for a gel of Young's modulus `young` (Pa) sampled every `spacing` (m) with Coulomb coefficient
    /// `friction`, active below the gap `offset` (m).
    ///
    /// A layer as thick as the spacing has stiffness `young / spacing`; contact is eighty times stiffer.
    pub fn new(young: f64, spacing: f64, friction: f64, offset: f64) -> Self {
        let stiffness = CONTACT_STIFFNESS * young / spacing;
        Self { stiffness, offset, friction, tangential: stiffness / 3.0 }
    }

    /// Returns this law with the reduced contact offset, for a point that only prevents penetration between points that
    /// carry the contact.
    pub fn with_reduced_offset(&self) -> Self {
        Self { offset: REDUCED_OFFSET * self.offset, ..*self }
    }

    /// Returns this law for a point with this `active_fraction`: its tangential stiffness is multiplied by it.
    pub fn with_active_fraction(&self, active_fraction: f64) -> Self {
        Self { tangential: active_fraction * self.tangential, ..*self }
    }

    /// Smallest gap of an accepted state, m.
    pub fn smallest_gap(&self) -> f64 {
        SMALLEST_GAP * self.offset
    }

    /// Pressure (Pa) and minus its derivative in the gap (Pa/m). `scale` multiplies the stiffness of a single edge.
    #[inline(always)]
    pub fn pressure(&self, gap: f64, scale: f64) -> (f64, f64) {
        let k = self.stiffness * scale;
        let closed = self.offset - gap;
        let hard = STIFFER_BRANCH * self.offset - gap;
        if closed <= 0.0 {
            (0.0, 0.0)
        } else if hard <= 0.0 {
            (k * closed, k)
        } else {
            (k * (closed + (STIFFER_BRANCH_RATIO - 1.0) * hard), STIFFER_BRANCH_RATIO * k)
        }
    }

    /// Energy per area, J/m2; its derivative in the gap is minus the pressure.
    #[inline(always)]
    pub fn normal_energy(&self, gap: f64, scale: f64) -> f64 {
        let closed = (self.offset - gap).max(0.0);
        let hard = (STIFFER_BRANCH * self.offset - gap).max(0.0);
        0.5 * self.stiffness * scale * (closed * closed + (STIFFER_BRANCH_RATIO - 1.0) * hard * hard)
    }

    /// Friction traction on the pad (Pa) at tangential displacement `s` (m) from the sticking point, for the limit
    /// `mu p` (Pa), and whether the point slips. The traction opposes `s`.
    #[inline(always)]
    pub fn traction(&self, s: DVec3, limit: f64) -> (DVec3, bool) {
        let trial = s * -self.tangential;
        let size = trial.length();
        (trial * cone_factor(size, limit), slips(size, limit))
    }

    /// Friction energy per area, J/m2, at fixed `limit`; its gradient in `s` is minus the traction.
    #[inline(always)]
    pub fn friction_energy(&self, s: DVec3, limit: f64) -> f64 {
        let size = s.length() * self.tangential;
        if slips(size, limit) { limit * (s.length() - 0.5 * limit / self.tangential) } else { 0.5 * size * s.length() }
    }

    /// Coefficients `(a, b)` of the friction Hessian `a (I - n n^T) - b t t^T`, Pa/m, with `t` the unit traction. For
    /// the `secant`, `b` is zero: the quadratic with this Hessian majorises the energy, so that its minimum is below
    /// the energy at the current point (Kacanov's method: Han, Jensen and Shimansky 1997).
    #[inline(always)]
    pub fn friction_hessian(&self, s: DVec3, limit: f64, secant: bool) -> (f64, f64) {
        let size = s.length() * self.tangential;
        if slips(size, limit) {
            let a = self.tangential * limit / size;
            (a, if secant { 0.0 } else { a })
        } else {
            (self.tangential, 0.0)
        }
    }
}
