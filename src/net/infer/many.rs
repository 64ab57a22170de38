//! Batched prediction of many grasps of an object. A thread finds the first contacts of a group of grasps, encodes
//! them, and decodes the group at once.

use super::FaceEngine;
use super::hold::{hold, pulls};
use super::predict::{Predictor, Seen};
use super::ramp::Ramp;
use crate::linear_response::GraspLoad;
use crate::linear_response::first_contact::GeometricContact;
use base::error::Result;
use base::interrupt;
use geometry::Pose;
use model::Model;
use rayon::prelude::*;
use std::sync::Arc;
use world::environment::Environment;

/// Largest number of grasps decoded together: with two pads each, they fill a register.
const TOGETHER: usize = 8;

/// Prediction of a grasp under those loads of its model that have an answer.
#[derive(Debug)]
pub struct PredictedGrasp {
    /// First contact.
    pub touch: GeometricContact,
    /// States under the loads.
    pub ramp: Ramp,
    /// Smallest remaining fraction of the friction limit under the loads; negative where the object slips.
    pub hold: f64,
}

impl Predictor {
    /// Predicts the grasps of `model` at `poses` under the loads that have an answer: see [`Predictor::answered`]. A
    /// grasp that cannot start, or whose numbers are not finite, has its own error.
    ///
    /// # Errors
    /// Fails if the scene, or each of its forces, is outside the trained range and may not be extrapolated, and if it
    /// is interrupted.
    pub fn many(&self, model: &Arc<Model>, poses: &[Pose], extrapolate: bool) -> Result<Vec<Result<PredictedGrasp>>> {
        let graph = self.admit_some(model, extrapolate)?;
        let loads: Vec<GraspLoad> = self.answered(model, extrapolate).into_iter().map(|(_, load)| load).collect();
        // Groups are small enough to occupy all threads; their composition does not change a single bit.
        let each = poses.len().div_ceil(rayon::current_num_threads());
        let together = (FaceEngine::LOADS / Ramp::decoded_at_first(model, &loads).max(1)).min(each).clamp(1, TOGETHER);
        let predict = |environment: &mut Option<Environment>, poses: &[Pose]| -> Result<Vec<_>> {
            interrupt::check()?;
            let touch = |pose: &Pose| GeometricContact::find_in(environment, model, *pose);
            let touches: Vec<Result<GeometricContact>> = poses.iter().map(touch).collect();
            let seen: Vec<Seen> =
                touches.iter().flatten().map(|touch| self.look(model, &graph, touch).as_needed()).collect();
            let mut ramps = Ramp::many(self, &seen.iter().collect::<Vec<_>>(), &loads).into_iter();
            let grasp = |touch: Result<GeometricContact>| {
                let (touch, ramp) = (touch?, ramps.next().expect("every contact has a ramp")?);
                let pulled = loads.iter().enumerate().filter(|(_, load)| pulls(&touch, load));
                let holds = pulled.filter_map(|(k, load)| Some(hold(model, &touch, &ramp.at(k)?, load)));
                let hold = holds.fold(1.0, f64::min);
                Ok(PredictedGrasp { touch, ramp, hold })
            };
            Ok(touches.into_iter().map(grasp).collect())
        };
        let groups: Result<Vec<Vec<_>>> = poses.par_chunks(together).map_init(|| None, predict).collect();
        Ok(groups?.into_iter().flatten().collect())
    }
}
