//! Tightly curved parts of a solid of revolution, which would penetrate a pad between its contact samples.

use super::feature_point::FeaturePoint;
use super::polygon::Profile;
use base::scales::{CORNER_CUT, SAMPLE_CUT};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Radius of curvature, over the requested spacing, above which the samples of a pad are sufficient.
const TIGHT_RADIUS: f64 = 24.0;

/// Circle about the z axis on a smooth convex part of a solid of revolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring {
    /// Point (rho, z), m.
    point: DVec2,
    /// Outward unit normal in the (rho, z) plane.
    normal: DVec2,
    /// Smaller of the two principal radii of curvature, m.
    radius: f64,
    /// Mean length of the segments that meet there, m, and the angle between their normals, rad.
    corner: (f64, f64),
}

impl Ring {
    /// Builds the ring of point `i` of a profile, where the normals of the two adjacent segments enclose the angle
    /// `turn` (rad).
    pub(crate) fn new(profile: &Profile, i: usize, turn: f64, normal: DVec2) -> Self {
        let (points, point) = (profile.points(), profile.points()[i]);
        let n = points.len();
        let [before, after] = [points[(i + n - 1) % n], points[(i + 1) % n]].map(|p| p.distance(point));
        // The profile ends on the axis: one of the two points is its other end; the true neighbour is the mirror image
        // of the other point.
        let on_axis = point.x == 0.0;
        let length = if on_axis { before.min(after) } else { 0.5 * (before + after) };
        let around = if !on_axis && normal.x > 0.0 { point.x / normal.x } else { f64::INFINITY };
        Self { point, normal, radius: around.min(length / turn), corner: (length, turn) }
    }

    /// Returns points on those of `rings`, in the order of a profile, that are tight for a pad whose points are twice
    /// `spacing` (m) apart: with a radius below [`TIGHT_RADIUS`] times `spacing`, or a corner that such a pad would cut
    /// by more than `CORNER_CUT` contact offsets. Contact has this `offset` (m).
    pub(crate) fn sample(rings: &[Self], spacing: f64, offset: f64) -> Vec<FeaturePoint> {
        let (mut points, mut last) = (Vec::new(), None::<DVec2>);
        let is_tight =
            |ring: &&Self| ring.radius < TIGHT_RADIUS * spacing || ring.cut(2.0 * spacing) > CORNER_CUT * offset;
        for ring in rings.iter().filter(is_tight) {
            let apart = (8.0 * ring.radius * SAMPLE_CUT * offset).sqrt();
            if last.is_some_and(|last| last.distance(ring.point) < 0.5 * apart) {
                continue;
            }
            last = Some(ring.point);
            let count = (TAU * ring.point.x / apart).ceil().clamp(1.0, 1e4) as u32;
            points.extend((0..count).map(|k| {
                let (sin, cos) = (TAU * f64::from(k) / f64::from(count)).sin_cos();
                let at = |p: DVec2| DVec3::new(p.x * cos, p.x * sin, p.y);
                FeaturePoint { position: at(ring.point), normal: at(ring.normal), sharp: false }
            }));
        }
        points
    }

    /// Returns the depth of the corner in a pad between two samples that are `apart` (m) from each other, m.
    fn cut(&self, apart: f64) -> f64 {
        let (length, turn) = self.corner;
        turn * length.min(apart) / 8.0
    }

    pub(crate) fn scaled(&self, factor: f64) -> Self {
        let (length, turn) = self.corner;
        let corner = (length * factor, turn);
        Self { point: self.point * factor, radius: self.radius * factor, corner, ..*self }
    }
}
