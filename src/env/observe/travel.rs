//! Observation of the travel of the fingers.

use super::{Now, Sense};
use crate::env::spec::ArraySpec;
use crate::model::Model;
use crate::scene::Task;

/// Travel of each finger since first contact, left first.
#[derive(Debug)]
pub struct FingerTravel {
    fingers: usize,
    stroke: f64,
}

impl FingerTravel {
    pub fn new(model: &Model, _: &Task) -> Self {
        Self { fingers: model.fingers.len(), stroke: model.stroke }
    }
}

impl Sense for FingerTravel {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("travel", &[self.fingers], "m", [-self.stroke, self.stroke])
    }

    fn write(&self, now: &Now, out: &mut [f32]) {
        out.iter_mut().zip(&now.frame.travel).for_each(|(o, t)| *o = *t as f32);
    }
}
