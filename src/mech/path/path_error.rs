//! Error of an increment: how far the path bends away from the straight line that friction assumes.
//!
//! A point that touches within an increment is assumed to have moved along a straight line from where it was to where it is,
//! and so is one that slips. Three states in a row show how the path bends. The last part of the parabola through them is
//! `h1^2 |x''| / 8 = (d1 - q d0) q / (4 (1 + q))` away from its chord in the middle, with the increments `d0` and `d1` of the
//! state and the ratio `q` of those of the load. That distance over the displacement is the error; it falls with the square of
//! the increment.

use super::Path;
use crate::mech::potential::state::State;

impl Path {
    /// Error of the increment to `next` at level `to`: how far the path bends away from a straight line, over what is allowed.
    /// It is zero where no error is asked for, where nothing is known of the path yet, or if the increment is so small that the
    /// path jumps rather than bends.
    pub(crate) fn bend(&self, next: &State, to: f64) -> f64 {
        let (Some(control), Some((before, at))) = (self.control, &self.history) else { return 0.0 };
        let [h0, h1] = [self.level - at, to - self.level];
        let q = h1 / h0;
        if !(q.is_finite() && q > 0.0) || h1.abs() < self.shortest(control.first) {
            return 0.0;
        }
        let part = q / (4.0 * (1.0 + q));
        let (mut bent, mut moved, mut largest) = (0.0, 0.0, 0.0_f64);
        for (body, next) in next.x.iter().enumerate() {
            let (x0, x1, rest) = (&before.x[body], &self.state.x[body], &self.newton.body(body).rest);
            for (((x2, x1), x0), rest) in next.iter().zip(x1).zip(x0).zip(rest) {
                bent += ((*x2 - *x1) - (*x1 - *x0) * q).length_squared();
                let u = x2.distance_squared(*rest);
                moved += u;
                largest = largest.max(u);
            }
        }
        let rigid = &self.newton.rigid;
        let [d0, d1] = [rigid.difference(&self.state, before), rigid.difference(next, &self.state)];
        let turned = d1.iter().zip(d0).map(|(d1, d0)| (d1 - q * d0).powi(2)).sum::<f64>();
        if moved == 0.0 {
            return 0.0;
        }
        part * (bent / moved).max(turned / largest).sqrt() / control.bend
    }

    /// Shortest increment whose error is looked at.
    pub(crate) fn shortest(&self, first: f64) -> f64 {
        (SHORTEST[0] * first).max(SHORTEST[1] * self.level.abs())
    }
}

/// Shortest increment over the load with which the path begins, and over the load reached.
const SHORTEST: [f64; 2] = [0.25, 1.0 / 32.0];
