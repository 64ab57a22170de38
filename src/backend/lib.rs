//! Backends: finite elements and a trained network implement the same stage of the schedule. Only this module depends
//! on both.

pub mod fallback;
pub mod fem;
pub mod network;
pub mod simulate;

use base::error::Result;
use world::Stepper;

/// Creates the backend that the scene selects.
///
/// # Errors
/// Fails if the trained model cannot be read.
pub fn choose(scene: &scene::Scene) -> Result<Box<dyn Stepper>> {
    match &scene.stepper {
        scene::StepperChoice::Fem(fem) => Ok(Box::new(fem::stepper::FemStepper::new(fem))),
        scene::StepperChoice::Gnn(gnn) => {
            let network = network::NetworkStepper::open(&gnn.model)?.extrapolating(gnn.extrapolate);
            Ok(match gnn.error_at_most {
                Some(most) => Box::new(fallback::NetworkWithFallback::new(network, most.get())),
                None => Box::new(network),
            })
        }
    }
}
