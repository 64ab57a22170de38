//! Tolerance within which what a description says is taken as parallel, square or in line: numbers are written by hand, or with few digits.

use glam::{DMat3, DVec3};

/// Angle, rad: 3.14, 1.57, 3.1416 and rounded quaternions stand for right angles.
pub(super) const ANGLE: f64 = 2e-3;
/// Length, m.
pub(super) const PLACE: f64 = 1e-4;
/// Difference that stems from rounding, in m or rad.
pub(super) const ROUNDING: f64 = 1e-9;

/// Deviations that were taken for none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Deviation {
    /// Largest angle, rad.
    pub angle: f64,
    /// Largest length, m.
    pub place: f64,
}

impl Deviation {
    /// Returns a unit vector without the components below [`ANGLE`]: within that angle of an axis it lies along it.
    pub fn squared(&mut self, v: DVec3) -> DVec3 {
        let squared = DVec3::from_array(v.to_array().map(|c| if c.abs() < ANGLE { 0.0 } else { c })).normalize();
        self.add_angle(v, squared);
        squared
    }

    /// Returns a rotation by right angles, if each of its axes lies within [`ANGLE`] of one, and the same rotation if not.
    pub fn turned(&mut self, rotation: DMat3) -> DMat3 {
        let mut own = Self::default();
        let axes = [rotation.x_axis, rotation.y_axis, rotation.z_axis].map(|axis| own.squared(axis));
        if axes.iter().any(|axis| axis.abs().max_element() < 1.0) {
            return rotation;
        }
        self.angle = self.angle.max(own.angle);
        DMat3::from_cols_array_2d(&axes.map(|axis| axis.to_array()))
    }

    /// Takes in the angle between two unit vectors that are nearly parallel.
    pub fn add_angle(&mut self, a: DVec3, b: DVec3) {
        self.angle = self.angle.max(a.cross(b).length().min(1.0).asin());
    }

    /// Takes in lengths, m.
    pub fn add_places(&mut self, lengths: &[f64]) {
        self.place = lengths.iter().fold(self.place, |largest, length| largest.max(length.abs()));
    }

    /// Returns a sentence about them, if there are any.
    pub fn notice(&self) -> Option<String> {
        let angle = format!("angles that are off by up to {:.1e} rad as parallel or square", self.angle);
        let place = format!("pads that are off by up to {:.2} um as facing each other", self.place * 1e6);
        let taken: Vec<String> = [(self.angle, angle), (self.place, place)]
            .into_iter()
            .filter(|(off, _)| *off > ROUNDING)
            .map(|(_, t)| t)
            .collect();
        (!taken.is_empty()).then(|| format!("takes {}", taken.join(", ")))
    }
}
