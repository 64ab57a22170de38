//! Dimensions of pads, and their range in a training set.

use glam::DVec3;
use record::{ElementNodes, PadTopology};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Dimensions of a pad.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sensor {
    /// Size along the approach, along the finger's width, and through the gel with its dome, m.
    pub size: [f64; 3],
    /// Mean edge length of the elements on the sensing face, m.
    pub spacing: f64,
    /// Number of nodes.
    pub nodes: usize,
}

impl Sensor {
    /// Measures a pad.
    pub fn of(pad: &PadTopology) -> Self {
        let ends =
            |pick: fn(DVec3, DVec3) -> DVec3, start: f64| pad.rest.iter().copied().fold(DVec3::splat(start), pick);
        let size = (ends(DVec3::max, f64::NEG_INFINITY) - ends(DVec3::min, f64::INFINITY)).max(DVec3::ZERO);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|n| pad.rest[n as usize]);
            0.5 * (b - a).cross(c - a).length()
        };
        let mean = pad.sensing.iter().map(area).sum::<f64>() / pad.sensing.len().max(1) as f64;
        // Two triangles form a cell of the face; for 10-node elements the list holds the four parts of each 6-node
        // triangle.
        let parts = if matches!(pad.elements, ElementNodes::Quadratic(_)) { 2.0 } else { 1.0 };
        Self { size: size.to_array(), spacing: parts * (2.0 * mean).sqrt(), nodes: pad.rest.len() }
    }
}

impl fmt::Display for Sensor {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [a, b, c] = self.size.map(|v| v * 1e3);
        write!(f, "{a:.2} x {b:.2} x {c:.2} mm, spacing {:.2} mm, {} nodes", self.spacing * 1e3, self.nodes)
    }
}

/// Smallest and largest pads of a training set, over their thickness (dome included).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PadRange {
    /// Size along the approach.
    pub length: [f64; 2],
    /// Size along the finger's width.
    pub width: [f64; 2],
    /// Mean edge length of the elements on the sensing face.
    pub spacing: [f64; 2],
}

impl PadRange {
    /// Returns the range of one pad.
    pub fn of(sensor: &Sensor) -> Self {
        let [length, width, thickness] = sensor.size;
        let [length, width, spacing] = [length, width, sensor.spacing].map(|v| [v / thickness; 2]);
        Self { length, width, spacing }
    }

    /// Returns the smallest range that contains both.
    pub fn join(self, other: Self) -> Self {
        let join = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self {
            length: join(self.length, other.length),
            width: join(self.width, other.width),
            spacing: join(self.spacing, other.spacing),
        }
    }

    /// Returns the ranges with their names.
    pub fn spans(&self) -> [(&'static str, [f64; 2]); 3] {
        [("length", self.length), ("width", self.width), ("spacing", self.spacing)]
    }

    /// Returns the first dimension of `other` that is outside the range by more than the fraction `slack`: its name,
    /// its value and the range.
    pub fn first_outside(&self, other: &Self, slack: f64) -> Option<(&'static str, f64, [f64; 2])> {
        let own = self.spans().into_iter().zip(other.spans());
        own.map(|((name, range), (_, [value, _]))| (name, value, range))
            .find(|(_, value, [low, high])| *value < low * (1.0 - slack) || *value > high * (1.0 + slack))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pad_between_two_is_within_their_range_whatever_its_thickness() {
        let pad = |length: f64, t: f64| Sensor { size: [length * t, 4.0 * t, t], spacing: 0.5 * t, nodes: 100 };
        let range = PadRange::of(&pad(4.0, 2e-3)).join(PadRange::of(&pad(8.0, 4e-3)));
        assert_eq!(range.first_outside(&PadRange::of(&pad(6.0, 7e-3)), 1e-6), None);
        let (name, value, [low, high]) = range.first_outside(&PadRange::of(&pad(9.0, 1e-3)), 1e-6).unwrap();
        assert_eq!(name, "length");
        assert!([value - 9.0, low - 4.0, high - 8.0].iter().all(|v| v.abs() < 1e-9), "{value} in {low} to {high}");
    }
}
