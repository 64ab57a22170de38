//! Observations of an agent, one file each.
//!
//! A new observation needs a variant in [`Observe`], a file with a [`Sense`], and a line each in `name` and `sense`.

mod force;
mod grid;
mod height_map;
mod object_pose;
mod prediction_error;
mod taxels;
mod travel;
mod wrench;

use super::spec::ArraySpec;
use crate::model::Model;
use crate::record::Frame;
use crate::scene::{Observe, Task};

/// Input of an observation.
#[derive(Debug, Clone, Copy)]
pub struct Now<'a> {
    /// The scene of this episode.
    pub model: &'a Model,
    /// The state after the step.
    pub frame: &'a Frame,
}

/// Writes one array.
pub trait Sense: Send + Sync + std::fmt::Debug {
    /// Describes the array.
    fn spec(&self) -> ArraySpec;
    /// Fills `out`, which has the size of the array.
    fn write(&self, now: &Now, out: &mut [f32]);
}

impl Observe {
    /// Returns the name of its array.
    pub fn name(&self) -> &'static str {
        match self {
            Observe::TaxelForce(_) => "taxel_force",
            Observe::TaxelDisplacement(_) => "taxel_displacement",
            Observe::HeightMap(_) => "height_map",
            Observe::Wrench => "wrench",
            Observe::Travel => "travel",
            Observe::ObjectPose => "object_pose",
            Observe::Force => "force",
            Observe::PredictionError => "prediction_error",
        }
    }

    /// Creates the sense that writes it, for episodes of `task` in scenes with the pads of `model`.
    pub fn sense(&self, model: &Model, task: &Task) -> Box<dyn Sense> {
        match self {
            Observe::TaxelForce(grid) => Box::new(taxels::ForceImage::new(model, task, grid)),
            Observe::TaxelDisplacement(grid) => Box::new(taxels::DisplacementImage::new(model, task, grid)),
            Observe::HeightMap(grid) => Box::new(height_map::HeightMap::new(model, grid)),
            Observe::Wrench => Box::new(wrench::PadWrench::new(model, task)),
            Observe::Travel => Box::new(travel::FingerTravel::new(model, task)),
            Observe::ObjectPose => Box::new(object_pose::PoseInHand::new(model, task)),
            Observe::Force => Box::new(force::Applied::new(model, task)),
            Observe::PredictionError => Box::new(prediction_error::PredictionError::new(model, task)),
        }
    }
}

/// Largest force of a contact over the largest force that the fingers are given.
const MOST: f64 = 10.0;

/// Returns the bounds of a contact force, N.
fn force_bounds(task: &Task) -> [f64; 2] {
    let most = MOST * task.force.at(1.0);
    [-most, most]
}
