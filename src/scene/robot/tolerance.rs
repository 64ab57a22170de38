//! Tolerances within which directions of a description count as parallel or perpendicular and positions as aligned,
//! because numbers are written with few digits.

use glam::{DMat3, DVec3};

/// Angular tolerance, rad: accepts 3.14, 1.57, 3.1416 and rounded quaternions as right angles.
pub(super) const ANGLE_TOLERANCE: f64 = 2e-3;
/// Position tolerance, m.
pub(super) const POSITION_TOLERANCE: f64 = 1e-4;
/// Difference attributed to rounding, m or rad.
pub(super) const ROUNDING_TOLERANCE: f64 = 1e-9;

/// Largest deviations that were accepted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Deviation {
    /// Largest angle, rad.
    pub angle: f64,
    /// Largest length, m.
    pub place: f64,
}

impl Deviation {
    /// Returns a unit vector with components below [`ANGLE_TOLERANCE`] set to zero: a vector within that angle of an
    /// axis is snapped to it.
    pub fn snap_vector(&mut self, v: DVec3) -> DVec3 {
        let squared =
            DVec3::from_array(v.to_array().map(|c| if c.abs() < ANGLE_TOLERANCE { 0.0 } else { c })).normalize();
        self.add_angle(v, squared);
        squared
    }

    /// Returns the rotation snapped to right angles if each of its axes is within [`ANGLE_TOLERANCE`] of a coordinate
    /// axis, otherwise unchanged.
    pub fn snap_rotation(&mut self, rotation: DMat3) -> DMat3 {
        let mut own = Self::default();
        let axes = [rotation.x_axis, rotation.y_axis, rotation.z_axis].map(|axis| own.snap_vector(axis));
        if axes.iter().any(|axis| axis.abs().max_element() < 1.0) {
            return rotation;
        }
        self.angle = self.angle.max(own.angle);
        DMat3::from_cols_array_2d(&axes.map(|axis| axis.to_array()))
    }

    /// Includes the angle between two nearly parallel unit vectors.
    pub fn add_angle(&mut self, a: DVec3, b: DVec3) {
        self.angle = self.angle.max(a.cross(b).length().min(1.0).asin());
    }

    /// Includes position errors, m.
    pub fn add_places(&mut self, lengths: &[f64]) {
        self.place = lengths.iter().fold(self.place, |largest, length| largest.max(length.abs()));
    }

    /// Returns a notice about the deviations above rounding, if any.
    pub fn notice(&self) -> Option<String> {
        let angle = format!("angles with errors of up to {:.1e} rad as parallel or perpendicular", self.angle);
        let place = format!("pads with offsets of up to {:.2} um as facing each other", self.place * 1e6);
        let taken: Vec<String> = [(self.angle, angle), (self.place, place)]
            .into_iter()
            .filter(|(off, _)| *off > ROUNDING_TOLERANCE)
            .map(|(_, t)| t)
            .collect();
        (!taken.is_empty()).then(|| format!("treats {}", taken.join(", ")))
    }
}
