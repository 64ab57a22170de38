//! Many grasps of an object at once: each finds its first contact, is encoded and decoded on a thread of its own.

use super::hold::{hold, pulls};
use super::predict::Predictor;
use super::ramp::Ramp;
use crate::error::Result;
use crate::gripper::GraspPose;
use crate::interrupt;
use crate::linear::first_contact::GeometricContact;
use crate::linear::loads_of;
use crate::model::Model;
use crate::world::environment::Environment;
use rayon::prelude::*;
use std::sync::Arc;

/// Prediction of a grasp under all loads of its model.
#[derive(Debug)]
pub struct PredictedGrasp {
    /// First contact.
    pub touch: GeometricContact,
    /// States under the loads.
    pub ramp: Ramp,
    /// Part of the friction limit that the loads leave at the worst; negative where the object slips.
    pub hold: f64,
}

impl Predictor {
    /// Predicts the grasps of `model` at `poses`. A grasp that cannot start, or has no finite answer, has its own error.
    ///
    /// # Errors
    /// Fails if the scene lies outside the trained range and may not be extrapolated, and if it is interrupted.
    pub fn many(
        &self,
        model: &Arc<Model>,
        poses: &[GraspPose],
        extrapolate: bool,
    ) -> Result<Vec<Result<PredictedGrasp>>> {
        let graph = self.admit(model, extrapolate)?;
        let loads = loads_of(model);
        let predict = |environment: &mut Option<Environment>, pose: &GraspPose| {
            interrupt::check()?;
            let touch = match GeometricContact::find_in(environment, model, *pose) {
                Ok(touch) => touch,
                Err(error) => return Ok(Err(error)),
            };
            let seen = self.look(model, &graph, &touch).as_needed();
            let ramp = match Ramp::new(self, &seen, &loads) {
                Ok(ramp) => ramp,
                Err(error) => return Ok(Err(error)),
            };
            let pulled = loads.iter().enumerate().filter(|(_, load)| pulls(&touch, load));
            let holds = pulled.filter_map(|(k, load)| Some(hold(model, &touch, &ramp.at(k)?, load)));
            let hold = holds.fold(1.0, f64::min);
            Ok(Ok(PredictedGrasp { touch, ramp, hold }))
        };
        poses.par_iter().map_init(|| None, predict).collect()
    }
}
