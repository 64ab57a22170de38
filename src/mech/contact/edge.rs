//! Contact law applied to the state of one edge.

use super::law::ContactLaw;
pub use crate::potential::edge::EdgeState;
use glam::DVec3;

impl EdgeState {
    /// Edge of a point that is out of reach of any surface.
    pub const OPEN: Self = Self {
        gap: f64::INFINITY,
        normal: DVec3::ZERO,
        pressure: 0.0,
        plane: DVec3::ZERO,
        limit: 0.0,
        traction: DVec3::ZERO,
        slips: false,
        anchor: None,
        initial_gap: None,
        active_fraction: 1.0,
        scale: 1.0,
    };

    /// Returns true if the edge is equivalent to [`EdgeState::OPEN`]: no surface is in reach, and there is no history.
    pub fn is_open(&self) -> bool {
        self.gap == f64::INFINITY
            && self.pressure <= 0.0
            && self.limit == 0.0
            && self.anchor.is_none()
            && self.scale == 1.0
    }

    /// Active fraction: part of the straight motion since the start of the increment during which the point has been in
    /// contact.
    pub fn current_active_fraction(&self, offset: f64) -> f64 {
        match self.initial_gap {
            Some(clear) if clear > offset && self.gap < offset => (offset - self.gap) / (clear - self.gap),
            Some(clear) if clear > offset => 0.0,
            _ => 1.0,
        }
    }

    /// Friction energy per area under `law`, J/m2, at tangential displacement `s` (m) from the sticking point and fixed
    /// limit.
    pub fn friction_energy(&self, law: &ContactLaw, s: DVec3) -> f64 {
        law.with_active_fraction(self.active_fraction).friction_energy(s, self.limit)
    }

    /// Sticking point, if friction acts.
    pub fn sticking_point(&self) -> Option<DVec3> {
        self.anchor.filter(|_| self.limit > 0.0)
    }

    /// Returns this edge with the pressure at one of its contact points, at `gap` (m) along `normal`.
    pub fn at_contact_point(&self, law: &ContactLaw, gap: f64, normal: DVec3) -> Self {
        Self { gap, normal, pressure: law.pressure(gap, self.scale).0, ..*self }
    }

    /// Sets pressure and normal from the contact points: gap (m), normal and weight of each, the nearest first.
    pub fn set_pressure(&mut self, law: &ContactLaw, mut places: impl Iterator<Item = (f64, DVec3, f64)>) {
        let Some((gap, normal, _)) = places.next() else {
            (self.gap, self.pressure) = (f64::INFINITY, 0.0);
            return;
        };
        (self.gap, self.normal, self.pressure) = (gap, normal, law.pressure(gap, self.scale).0);
        let others: DVec3 = places.map(|(gap, n, weight)| n * (weight * law.pressure(gap, self.scale).0)).sum();
        if others != DVec3::ZERO {
            let force = normal * self.pressure + others;
            self.pressure = force.length();
            self.normal = force.try_normalize().unwrap_or(normal);
        }
    }

    /// Sets the friction limit to `friction` times the pressure and the normal of the friction plane to the current one
    /// if it is to `update_friction`; a plane not yet set is always set. Returns the lag of the limit, Pa.
    pub fn set_limit(&mut self, friction: f64, update_friction: bool) -> f64 {
        if update_friction || self.plane == DVec3::ZERO {
            self.plane = self.normal;
        }
        let goal = friction * self.pressure;
        self.limit = if update_friction { goal } else { self.limit };
        (goal - self.limit).abs()
    }
}
