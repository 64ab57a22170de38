//! Dimensions of pads over their thickness, and their range in a training set. They do not depend on a mesh.

use geometry::Aabb;
use record::PadTopology;
use serde::{Deserialize, Serialize};

/// Smallest and largest pads of a training set, over their thickness (dome included).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PadRange {
    /// Length of the sensing face along the approach.
    pub length: [f64; 2],
    /// Width of the sensing face along the finger's width.
    pub width: [f64; 2],
    /// Height of the dome: depth of the rim of the sensing face below its apex.
    pub dome: [f64; 2],
}

impl PadRange {
    /// Returns the range of one pad.
    pub fn of(pad: &PadTopology) -> Self {
        let face = Aabb::from_points(pad.sensing.as_flattened().iter().map(|node| pad.rest[*node as usize]));
        let [length, width, dome] = (face.size() / pad.thickness()).to_array().map(|v| [v.max(0.0); 2]);
        Self { length, width, dome }
    }

    /// Returns the smallest range that contains both.
    pub fn join(self, other: Self) -> Self {
        let join = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self {
            length: join(self.length, other.length),
            width: join(self.width, other.width),
            dome: join(self.dome, other.dome),
        }
    }

    /// Returns the ranges with their names.
    pub fn spans(&self) -> [(&'static str, [f64; 2]); 3] {
        [("length", self.length), ("width", self.width), ("height of the dome", self.dome)]
    }

    /// Returns the first dimension of `other` that is outside the range by more than the fraction `slack` of the
    /// thickness: its name, its value and the range.
    pub fn first_outside(&self, other: &Self, slack: f64) -> Option<(&'static str, f64, [f64; 2])> {
        let own = self.spans().into_iter().zip(other.spans());
        own.map(|((name, range), (_, [value, _]))| (name, value, range))
            .find(|(_, value, [low, high])| *value < low - slack || *value > high + slack)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pad_between_two_is_within_their_range() {
        let pad = |length: f64| PadRange { length: [length; 2], width: [4.0; 2], dome: [0.0; 2] };
        let range = pad(4.0).join(pad(8.0));
        assert_eq!(range.first_outside(&pad(6.0), 1e-6), None);
        let (name, value, [low, high]) = range.first_outside(&pad(9.0), 1e-6).unwrap();
        assert_eq!((name, value, low, high), ("length", 9.0, 4.0, 8.0));
    }
}
