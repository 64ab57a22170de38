//! Backends: finite elements and a trained network in the same slot of the same schedule. Only this module knows both.

pub mod fem;
pub mod network;

use crate::error::Result;
use crate::scene;
use crate::world::Stepper;

/// Creates the backend that the scene names.
///
/// # Errors
/// Fails if the trained model cannot be read.
pub fn choose(scene: &scene::Scene) -> Result<Box<dyn Stepper>> {
    match &scene.stepper {
        scene::StepperChoice::Fem(fem) => Ok(Box::new(fem::stepper::FemStepper::new(fem))),
        scene::StepperChoice::Gnn(gnn) => Ok(Box::new(network::NetworkStepper::open(&gnn.model)?)),
    }
}
