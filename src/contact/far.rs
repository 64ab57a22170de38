//! Which features of the object are too far from a pad to be looked for, and which cannot be inside it: neither they nor the pad move
//! faster than they move.

use super::project::FaceBounds;
use super::surface::ContactSurface;
use glam::DVec3;

/// Motion of the pad after which the distances are taken anew, m: a fraction of what most features are away.
const STALE: f64 = 2e-4;

/// Distances of all features to the pad, at an earlier state.
#[derive(Debug, Clone, Default)]
pub(super) struct Far {
    /// Node positions then, m.
    x: Vec<DVec3>,
    /// Where each feature was, relative to the finger, and how far outside the pad at least, m.
    features: Vec<(DVec3, f64)>,
}

impl Far {
    /// Takes the distances of `count` features anew if the pad at `x` has moved too far since the last time; `place` says where
    /// each of them is.
    pub fn update(
        &mut self,
        surface: &ContactSurface,
        x: &[DVec3],
        bounds: &FaceBounds,
        count: usize,
        place: impl Fn(usize) -> DVec3,
    ) {
        let moved = self.moved(x);
        if moved > STALE {
            let away = |i: usize| {
                let y = place(i);
                let gap = bounds.outside(surface, x, y);
                (y, if self.has_flipped(i, y, moved, gap) { -gap } else { gap })
            };
            self.features = (0..count).map(away).collect();
            self.x = x.to_vec();
        }
    }

    /// Largest motion of a node since the distances were taken, m; `+inf` if they never were.
    pub fn moved(&self, x: &[DVec3]) -> f64 {
        if self.x.len() != x.len() {
            return f64::INFINITY;
        }
        self.x.iter().zip(x).map(|(a, b)| a.distance_squared(*b)).fold(0.0, f64::max).sqrt()
    }

    /// Whether feature `i`, now at `y`, may be nearer than `reach` (m) to the pad, which has `moved` by up to that (m).
    pub fn within(&self, i: usize, y: DVec3, moved: f64, reach: f64) -> bool {
        self.least(i, y, moved).is_none_or(|least| least <= reach)
    }

    /// Whether feature `i` cannot have got as deep as `gap` (m) says: where a face at the rim of a pad is folded over, what is
    /// outside looks as if it were inside.
    pub fn has_flipped(&self, i: usize, y: DVec3, moved: f64, gap: f64) -> bool {
        gap < 0.0 && self.least(i, y, moved).is_some_and(|least| gap < least)
    }

    /// Signed distance of feature `i` at least, m; None if it was never looked for.
    fn least(&self, i: usize, y: DVec3, moved: f64) -> Option<f64> {
        self.features.get(i).map(|(then, away)| away - BULGE * moved - then.distance(y))
    }
}

/// A point of a quadratic face moves at most this many times as far as its nodes: the sum of the magnitudes of its shape functions.
const BULGE: f64 = 5.0 / 3.0;
