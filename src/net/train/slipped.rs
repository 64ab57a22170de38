//! Grasps of data sets whose object slipped under a push, for the interval of the slip margin.

use super::data;
use crate::infer::friction_margin::SlipLoad;
use crate::infer::predict::Predictor;
use crate::linear_response::canonical_pads::{CanonicalPadList, CanonicalPads};
use crate::linear_response::first_contact::GeometricContact;
use crate::linear_response::{GraspLoad, frame_loads};
use base::error::Result;
use base::interrupt;
use dataset::split::GraspNumbers;
use dataset::{DataSet, ObjectFile};
use geometry::{Pose, Wrench};
use model::Model;
use rayon::prelude::*;
use std::sync::Arc;

/// Grasp that slipped.
#[derive(Debug, Clone)]
pub struct SlippedGrasp {
    model: Arc<Model>,
    pads: CanonicalPads,
    first_contact: GeometricContact,
    /// Load midway between the last frame that the grasp held and the next one.
    load: GraspLoad,
}

/// Reads the grasps of each set's poses that were dropped under a push.
///
/// # Errors
/// Fails for damaged files or grasps.
pub fn read(sets: &[(&DataSet, &GraspNumbers)], known: &CanonicalPadList) -> Result<Vec<SlippedGrasp>> {
    let mut slipped = Vec::new();
    for (set, poses) in sets {
        let dropped = set.select_dropped(poses);
        let models = data::models_of(set, &dropped, known)?;
        let read = dropped.par_iter().map(|(o, grasp)| {
            interrupt::check()?;
            let (model, pads) = &models[o];
            SlippedGrasp::read(&set.objects[*o], model, pads, *grasp)
        });
        slipped.extend(read.collect::<Result<Vec<_>>>()?.into_iter().flatten());
    }
    Ok(slipped)
}

impl SlippedGrasp {
    /// Reads a dropped grasp; None if it was dropped before the push.
    fn read(file: &ObjectFile, model: &Arc<Model>, pads: &CanonicalPads, grasp: usize) -> Result<Option<Self>> {
        let data = file.grasp(grasp)?;
        let loads = frame_loads(model);
        let Some(last) = data.frames.checked_sub(1) else { return Ok(None) };
        let (Some(held), Some(lost)) = (loads.get(last), loads.get(data.frames)) else { return Ok(None) };
        if lost.push == Wrench::ZERO {
            return Ok(None);
        }
        let push = Wrench {
            force: 0.5 * (held.push.force + lost.push.force),
            torque: 0.5 * (held.push.torque + lost.push.torque),
        };
        let load = GraspLoad { force: lost.force, push };
        let first_contact = pads.first_contact(Pose::from_row(&data.grasp_pose))?;
        Ok(Some(Self { model: model.clone(), pads: pads.clone(), first_contact, load }))
    }

    /// Returns the load at which it slipped, as `predictor` sees it; None if there is no prediction for it.
    pub(crate) fn slip_load(&self, predictor: &Predictor) -> Option<SlipLoad> {
        let encoded = predictor.encode_first_contact(&self.pads, &self.first_contact);
        let state = predictor.at(&encoded, self.load).ok()?;
        SlipLoad::of(&self.model, &self.first_contact, &state, &self.load).filter(|load| load.used > 0.0)
    }
}
