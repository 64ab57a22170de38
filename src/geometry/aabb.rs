//! Axis-aligned boxes.

use glam::DVec3;

/// Axis-aligned box, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Aabb {
    /// Smallest corner, m.
    pub min: DVec3,
    /// Largest corner, m.
    pub max: DVec3,
}

impl Aabb {
    /// Empty box: the neutral element of [`Aabb::include`].
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// Returns the smallest box around `points`.
    pub fn from_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |mut b, p| {
            b.include(p);
            b
        })
    }

    /// Grows the box to contain `p`.
    pub fn include(&mut self, p: DVec3) {
        self.min = self.min.min(p);
        self.max = self.max.max(p);
    }

    /// Grows the box to contain `other`.
    pub fn merge(&mut self, other: &Self) {
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }

    /// Returns the edge lengths, m.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// Returns the centre, m.
    pub fn center(&self) -> DVec3 {
        0.5 * (self.min + self.max)
    }

    /// Returns the squared distance from `q` to the box, m2; zero inside.
    #[inline]
    pub fn distance_squared(&self, q: DVec3) -> f64 {
        (self.min - q).max(q - self.max).max(DVec3::ZERO).length_squared()
    }

    /// Returns true if the two boxes have a point in common.
    pub fn intersects(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Returns the parameter `t` at which the ray `o + t / inverse` enters the box, if it does so at some `0 <= t <=
    /// max`.
    #[inline]
    pub fn ray_entry(&self, o: DVec3, inverse: DVec3, max: f64) -> Option<f64> {
        let (a, b) = ((self.min - o) * inverse, (self.max - o) * inverse);
        // A component is 0 * inf = NaN when the ray lies in a slab's plane; f64::min/max ignore the NaN, as intended.
        let enter = a.x.min(b.x).max(a.y.min(b.y)).max(a.z.min(b.z)).max(0.0);
        let leave = a.x.max(b.x).min(a.y.max(b.y)).min(a.z.max(b.z)).min(max);
        // The slack includes rays that graze the face of a flat box.
        (enter <= leave * (1.0 + 4.0 * f64::EPSILON)).then_some(enter)
    }
}
