//! Grasps that a network is least sure of: those that finite elements can teach it most about.

use super::predict::Predictor;
use crate::error::{Error, Result};
use crate::gripper::GraspPose;
use crate::linear::first_contact::GeometricContact;
use crate::linear::loads_of;
use crate::model::Model;
use crate::scene::Scene;

/// Returns for each grasp of `scene` the error that nine of ten such predictions of the displacement stay below under the last load; zero
/// for a grasp that cannot start, and infinite outside the range of the training, where it is unknown.
///
/// # Errors
/// Fails if the scene cannot be built, and for a model that knows nothing of its error.
pub fn doubts(predictor: &Predictor, scene: &Scene, poses: &[GraspPose]) -> Result<Vec<f64>> {
    if let Some(unknown) = predictor.card.unknown_error() {
        return Err(Error::Start(unknown));
    }
    let model = Model::build(&scene.on_own_mesh())?;
    let graph = predictor.graph(&model)?;
    let loads = loads_of(&model);
    let last = loads.last().copied().unwrap_or_default();
    let doubt = |pose: &GraspPose| {
        let Ok(touch) = GeometricContact::find(&model, *pose) else { return Ok(0.0) };
        Ok(predictor.at(&predictor.look(&model, &graph, &touch), last)?.error.displacement)
    };
    poses.iter().map(doubt).collect()
}
