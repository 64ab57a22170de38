//! Ball, pin or capsule so thin that it would penetrate a pad between its contact samples.

use super::feature_point::FeaturePoint;
use base::scales::{ROD_CUT, SAMPLE_CUT};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Rod: all points within a radius of a segment of the z axis about the origin; a ball if the segment has no length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rod {
    /// Radius, m.
    pub radius: f64,
    /// Half the length of the straight part, m.
    pub half: f64,
    /// True if hemispheres close the rod; otherwise only its lateral surface is sampled.
    pub capped: bool,
}

impl Rod {
    /// Returns points all over the rod if a pad whose points are twice `spacing` (m) apart would miss it: points of the
    /// pad are up to two fifths of that distance from the nearest vertex or triangle centre, and over a length `a` the
    /// surface of a ball of radius `r` recedes by `a^2 / (2 r)`. Contact has this `offset` (m).
    pub(crate) fn sample(&self, spacing: f64, offset: f64) -> Vec<FeaturePoint> {
        let fall = |a: f64| a * a / (2.0 * self.radius);
        if fall(0.8 * spacing) <= ROD_CUT * offset {
            return Vec::new();
        }
        // Spacing of the rings along the meridian, and of the points on them: at the centre of a square of four points
        // the rod is then `SAMPLE_CUT` contact offsets deep in the pad.
        let apart = 2.0 * (self.radius * SAMPLE_CUT * offset).sqrt();
        let cap = if self.capped { self.radius * FRAC_PI_2 } else { 0.0 };
        let reach = self.half + cap;
        let rings = (2.0 * reach / apart).ceil().clamp(2.0, 1e3) as u32;
        let ring = |k: u32| {
            let s = reach * (2.0 * f64::from(k) / f64::from(rings) - 1.0);
            let axial = s.clamp(-self.half, self.half);
            let normal = DVec2::from_angle((s - axial) / self.radius);
            let around = (TAU * self.radius * normal.x / apart).ceil().clamp(1.0, 1e3) as u32;
            (0..around).map(move |j| {
                let (sin, cos) = (TAU * f64::from(j) / f64::from(around)).sin_cos();
                let normal = DVec3::new(normal.x * cos, normal.x * sin, normal.y);
                FeaturePoint { position: self.radius * normal + axial * DVec3::Z, normal, sharp: false }
            })
        };
        // The ends of an uncapped rod are rims, which are sampled as sharp edges.
        let ends = u32::from(!self.capped);
        (ends..=rings - ends).flat_map(ring).collect()
    }

    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self { radius: factor * self.radius, half: factor * self.half, ..*self }
    }
}
