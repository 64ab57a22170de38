//! Drive of a finger: the limits of its speed and its travel.

use super::block::BodyBlock;
use super::state::{BodyView, IncrementStart};
use super::term::{Assembly, BodyTerm};
use crate::body::Body;
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};

/// Energy `c / 2 h (t - t0)2 + k / 2 max(t - end, 0)2` of the travel `t`: a motor whose force decreases with its speed,
/// and a stop at the end of the stroke. The solver applies the driving force itself.
#[derive(Debug, Clone)]
pub struct Drive {
    /// Largest force of this finger, N.
    rated: f64,
    /// Damping, N s/m.
    damping: f64,
    /// Largest travel, m, and the stiffness of its stop, N/m.
    end: f64,
    stop: f64,
    /// Travel at the last accepted state, m.
    travel: f64,
    size: f64,
}

impl Drive {
    /// Creates the drive of a finger at `travel` (m) that closes freely with `speed` (m/s) under the `rated` force (N),
    /// up to `end` (m), where the rated force pushes it into the stop by `yields` (m).
    pub fn new(rated: f64, speed: f64, end: f64, yields: f64, travel: f64) -> Self {
        Self { rated, damping: rated / speed, end, stop: rated / yields, travel, size: 1.0 }
    }
}

/// Travel of the finger that `view` belongs to.
fn travel(view: &BodyView) -> f64 {
    view.offset.dot(view.closing)
}

impl BodyTerm for Drive {
    fn energy(&self, _: &Body, view: &BodyView) -> f64 {
        let (moved, past) = (travel(view) - self.travel, (travel(view) - self.end).max(0.0));
        0.5 * (self.damping / self.size * moved * moved + self.stop * past * past)
    }

    fn assemble(&mut self, _: &Body, view: &BodyView, _: Assembly, block: &mut BodyBlock) {
        let Some(c) = view.travel_column else { return };
        let (moved, past) = (travel(view) - self.travel, (travel(view) - self.end).max(0.0));
        block.rigid.gradient[c] += self.damping / self.size * moved + self.stop * past;
        if block.wants_hessian() {
            block.rigid.hessian[c][c] += self.damping / self.size + if past > 0.0 { self.stop } else { 0.0 };
        }
        block.rigid.force_scale += self.rated;
    }

    fn begin_increment(&mut self, from: &IncrementStart) {
        self.size = from.step.map_or(self.size, |step| step.size);
    }

    fn commit(&mut self, _: &Body, view: &BodyView) {
        self.travel = travel(view);
    }

    fn save_state(&self, history: &mut StateWriter) {
        history.write(&self.travel);
    }

    fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        self.travel = history.read()?;
        Ok(())
    }
}
