//! Loads that pads carry by friction.
//!
//! The limit surface of the contacts is approximated by an ellipsoid in tangential force and in torque about the
//! closing direction (Goyal, Ruina and Papadopoulos 1991; Howe and Cutkosky 1996), from the pressure on the pads:
//! `(f / mu N)^2 + (m / mu sum p r)^2 = 1`.

use glam::DVec3;

/// Limit surface of the pressure on an object between pads.
#[derive(Debug, Clone, Copy)]
pub struct LimitSurface {
    closing: DVec3,
    /// Sum of the normal forces, N.
    normal: f64,
    /// Centroid of the pressure, m.
    center: DVec3,
    /// Sum of the normal forces times their distances from the axis through the centre, N m.
    arm: f64,
}

/// Fraction of a limit surface that a load uses.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LimitFraction {
    /// Fraction of the limit: 0 without load, 1 where the object slips as a whole.
    pub whole: f64,
    /// Share of the torque about the closing direction in the fraction, from 0 to 1.
    pub twist: f64,
    /// Moment perpendicular to the closing direction, which tilts the object, over pressing force and mean distance of
    /// the pressure from its centre.
    pub tilt: f64,
}

impl LimitSurface {
    /// Creates the surface of points that press along `closing` or against it: normal forces (N) with their positions
    /// (m), in one frame.
    pub fn new(closing: DVec3, presses: impl Iterator<Item = (f64, DVec3)> + Clone) -> Self {
        let normal: f64 = presses.clone().map(|(p, _)| p).sum();
        let center = presses.clone().map(|(p, x)| x * p).sum::<DVec3>() / normal.max(f64::MIN_POSITIVE);
        let arm = presses.map(|(p, x)| p * (x - center).reject_from(closing).length()).sum();
        Self { closing, normal, center, arm }
    }

    /// Returns the fraction of the limit, for the coefficient `friction`, that a force (N) at a point (m) and a torque (N
    /// m) use.
    pub fn used(&self, friction: f64, force: DVec3, at: DVec3, torque: DVec3) -> LimitFraction {
        if self.normal <= 0.0 {
            let loaded = force != DVec3::ZERO || torque != DVec3::ZERO;
            return LimitFraction { whole: if loaded { f64::INFINITY } else { 0.0 }, ..LimitFraction::default() };
        }
        let moment = (at - self.center).cross(force) + torque;
        let part = |value: f64, limit: f64| if value == 0.0 { 0.0 } else { value / (friction * limit) };
        let across = part(force.reject_from(self.closing).length(), self.normal);
        let twist = part(moment.dot(self.closing).abs(), self.arm);
        let whole = across.hypot(twist);
        let tilt = moment.reject_from(self.closing).length() / self.arm.max(f64::MIN_POSITIVE);
        LimitFraction { whole, twist: if whole > 0.0 { twist / whole } else { 0.0 }, tilt }
    }

    /// Returns the mean distance of the pressure from the axis through its centre, m.
    pub fn radius(&self) -> f64 {
        self.arm / self.normal.max(f64::MIN_POSITIVE)
    }

    /// Returns the centroid of the pressure, m.
    pub fn center(&self) -> DVec3 {
        self.center
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ring of pressure of 8 N and 5 mm radius under friction 0.5: 4 N across, 20 N mm about the closing direction.
    #[test]
    fn a_ring_of_pressure_holds_what_coulomb_lets_it() {
        let ring = (0..16).map(|k| {
            let angle = std::f64::consts::TAU * f64::from(k) / 16.0;
            (0.5, DVec3::new(0.0, angle.cos(), angle.sin()) * 5e-3)
        });
        let surface = LimitSurface::new(DVec3::X, ring);
        let margin = |force: DVec3, torque: f64| 1.0 - surface.used(0.5, force, DVec3::ZERO, DVec3::X * torque).whole;
        assert_eq!(margin(DVec3::ZERO, 0.0), 1.0);
        assert!(margin(DVec3::Y * 4.0, 0.0).abs() < 1e-12);
        assert!(margin(DVec3::ZERO, 0.02).abs() < 1e-12);
        assert!(
            (margin(DVec3::new(9.0, 0.0, 2.0), 0.01) - (1.0 - 0.5_f64.sqrt())).abs() < 1e-12,
            "the pads carry what is along them"
        );
        let nothing = LimitSurface::new(DVec3::X, std::iter::empty());
        assert!(nothing.used(0.5, DVec3::Y, DVec3::ZERO, DVec3::ZERO).whole > 1.0);
    }
}
