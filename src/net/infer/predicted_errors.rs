//! Grasps with the largest predicted error, which are the most useful to add to a training set.

use super::predict::Predictor;
use crate::linear_response::frame_loads;
use base::error::{Error, Result};
use geometry::Pose;
use model::Model;
use scene::Scene;

/// Returns for each grasp of `scene` the upper end of the prediction interval (90 %) of the displacement error under
/// the last load; zero for a grasp that cannot start, infinite (unknown) outside the range of the training.
///
/// # Errors
/// Fails if the scene cannot be built, and for a model without prediction intervals.
pub fn predicted_errors(predictor: &Predictor, scene: &Scene, poses: &[Pose]) -> Result<Vec<f64>> {
    if let Some(unknown) = predictor.card.unknown_error() {
        return Err(Error::Start(unknown));
    }
    let model = Model::build(&scene.without_finer_mesh())?;
    let pads = predictor.canonical_pads(&model)?;
    let loads = frame_loads(&model);
    let last = loads.last().copied().unwrap_or_default();
    let doubt = |pose: &Pose| {
        let Ok(touch) = pads.first_contact(*pose) else { return Ok(0.0) };
        Ok(predictor.at(&predictor.encode_first_contact(&pads, &touch), last)?.error.displacement)
    };
    poses.iter().map(doubt).collect()
}
