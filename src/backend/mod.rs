//! The backends: finite elements and a trained network in the same slot of the same schedule. The one place that knows both.

pub mod fem;
pub mod network;

use crate::error::Result;
use crate::scene;
use crate::world::Stepper;

/// The backend that the scene names.
///
/// # Errors
/// A trained model that cannot be read.
pub fn choose(scene: &scene::Scene) -> Result<Box<dyn Stepper>> {
    match &scene.stepper {
        scene::Stepper::Fem(fem) => Ok(Box::new(fem::stepper::Fem::new(fem))),
        scene::Stepper::Gnn(gnn) => Ok(Box::new(network::Gnn::open(&gnn.model)?)),
    }
}
