//! Batched prediction of many grasps of an object. A thread finds the first contacts of a group of grasps, encodes
//! them, and decodes the group at once.

use super::FaceEngine;
use super::friction_margin::carries_load;
use super::load_interpolation::LoadInterpolation;
use super::predict::{EncodedGrasp, Predictor};
use crate::linear_response::GraspLoad;
use crate::linear_response::first_contact::GeometricContact;
use crate::network::slip_interval::FrictionMargin;
use base::error::Result;
use base::interrupt;
use geometry::Pose;
use model::Model;
use rayon::prelude::*;
use std::sync::Arc;

/// Largest number of grasps decoded together: with two pads each, they fill a register.
const MAX_BATCH: usize = 8;

/// Prediction of a grasp under those loads of its model that have an answer.
#[derive(Debug)]
pub struct PredictedGrasp {
    /// First contact.
    pub first_contact: GeometricContact,
    /// States under the loads.
    pub interpolation: LoadInterpolation,
    /// Smallest remaining fraction of the load at which the object slips; negative where it slips.
    pub friction_margin: FrictionMargin,
}

impl Predictor {
    /// Predicts the grasps of `model` at `poses` under the loads that have an answer: see
    /// [`Predictor::answerable_loads`]. A grasp that cannot start, or whose numbers are not finite, has its own error.
    ///
    /// # Errors
    /// Fails if the scene, or each of its forces, is outside the trained range and may not be extrapolated, and if it
    /// is interrupted.
    pub fn predict_batch(
        &self,
        model: &Arc<Model>,
        poses: &[Pose],
        extrapolate: bool,
    ) -> Result<Vec<Result<PredictedGrasp>>> {
        let pads = self.pads_if_some_force_in_range(model, extrapolate)?;
        let loads: Vec<GraspLoad> =
            self.answerable_loads(model, extrapolate).into_iter().map(|(_, load)| load).collect();
        // Groups are small enough to occupy all threads; their composition does not change a single bit.
        let each = poses.len().div_ceil(rayon::current_num_threads());
        let together = (FaceEngine::LOADS_PER_BATCH / LoadInterpolation::initial_load_count(model, &loads).max(1))
            .min(each)
            .clamp(1, MAX_BATCH);
        let predict = |poses: &[Pose]| -> Result<Vec<_>> {
            interrupt::check()?;
            let touches: Vec<Result<GeometricContact>> = poses.iter().map(|pose| pads.first_contact(*pose)).collect();
            let encoded: Vec<EncodedGrasp> = touches
                .iter()
                .flatten()
                .map(|touch| self.encode_first_contact(&pads, touch).with_needed_fields())
                .collect();
            let mut ramps =
                LoadInterpolation::decode_batch(self, &encoded.iter().collect::<Vec<_>>(), &loads).into_iter();
            let grasp = |touch: Result<GeometricContact>| {
                let (touch, ramp) = (touch?, ramps.next().expect("every contact has a ramp")?);
                let pulled = loads.iter().enumerate().filter(|(_, load)| carries_load(&touch, load));
                let margins =
                    pulled.filter_map(|(k, load)| Some(self.friction_margin(model, &touch, &ramp.at(k)?, load)));
                let margin = margins.fold(FrictionMargin::WHOLE, FrictionMargin::or_smaller);
                Ok(PredictedGrasp { first_contact: touch, interpolation: ramp, friction_margin: margin })
            };
            Ok(touches.into_iter().map(grasp).collect())
        };
        let groups: Result<Vec<Vec<_>>> = poses.par_chunks(together).map(predict).collect();
        Ok(groups?.into_iter().flatten().collect())
    }
}
