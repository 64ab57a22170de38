//! Error of an increment: deviation of the path from the straight line that friction assumes.
//!
//! A point that makes contact or slips within an increment is assumed to move along a straight line. Three consecutive
//! states show the curvature of the path. The last part of the parabola through them deviates from its chord at the
//! midpoint by `h1^2 |x''| / 8 = (d1 - q d0) q / (4 (1 + q))`, with the increments `d0` and `d1` of the state and the
//! ratio `q` of the load increments. This deviation over the displacement is the error; it decreases with the square of
//! the increment.

use super::Path;
use crate::potential::state::State;

impl Path {
    /// Path error of the increment to `next` at level `to`, over the error allowed. It is zero without error control or
    /// history, and for an increment so small that the deviation is a jump, not a curvature.
    pub(crate) fn path_error(&self, next: &State, to: f64) -> f64 {
        let (Some(control), Some((before, at))) = (self.control, &self.previous) else { return 0.0 };
        let [h0, h1] = [self.level - at, to - self.level];
        let q = h1 / h0;
        if !(q.is_finite() && q > 0.0) || h1.abs() < self.shortest_rated_increment(control.first_load) {
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
        part * (bent / moved).max(turned / largest).sqrt() / control.max_path_error
    }

    /// Shortest increment whose error is evaluated.
    pub(crate) fn shortest_rated_increment(&self, first: f64) -> f64 {
        (SHORTEST_RATED_INCREMENT[0] * first).max(SHORTEST_RATED_INCREMENT[1] * self.level.abs())
    }
}

/// Shortest increment over the first load of the path, and over the current load.
const SHORTEST_RATED_INCREMENT: [f64; 2] = [0.25, 1.0 / 32.0];
