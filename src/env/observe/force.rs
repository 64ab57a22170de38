//! Observation of the closing force of the fingers.

use super::{Now, Sense};
use crate::env::spec::ArraySpec;
use crate::model::Model;
use crate::scene::Task;

/// Sum of the finger forces.
#[derive(Debug)]
pub struct Applied {
    most: f64,
}

impl Applied {
    pub fn new(_: &Model, task: &Task) -> Self {
        Self { most: task.force.at(1.0) }
    }
}

impl Sense for Applied {
    fn spec(&self) -> ArraySpec {
        ArraySpec::new("force", &[1], "N", [0.0, self.most])
    }

    fn write(&self, now: &Now, out: &mut [f32]) {
        out[0] = now.frame.applied_force as f32;
    }
}
