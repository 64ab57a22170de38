//! Network that knows where it is good enough: other grasps go to finite elements.

use super::fem::stepper::FemStepper;
use super::network::NetworkStepper;
use crate::error::{Error, Result};
use crate::model::Model;
use crate::scene::{Condensed, Fem, Solver};
use crate::world::Stepper;
use crate::world::schedule::HandedOver;
use bevy_ecs::prelude::*;

/// Network, with condensed finite elements for grasps that it is not sure of.
#[derive(Debug)]
pub struct GuardedNetwork {
    network: NetworkStepper,
    elements: FemStepper,
    /// Largest error of the displacement that is accepted.
    at_most: f64,
}

impl GuardedNetwork {
    /// Creates the guard of `network`.
    pub fn new(network: NetworkStepper, at_most: f64) -> Self {
        let elements = Fem { solver: Solver::Condensed(Condensed::default()), ..Fem::default() };
        Self { network, elements: FemStepper::new(&elements), at_most }
    }

    /// Returns why a grasp is not one for the network; None if it is.
    fn doubt(&self, world: &mut World) -> Result<Option<String>> {
        match self.network.prepare(world).and_then(|()| self.network.foresee(world)) {
            Ok(Some(error)) if error <= self.at_most => Ok(None),
            Ok(Some(error)) => Ok(Some(format!(
                "nine of ten such predictions are off by at most {:.1} % in displacement, accepted are {:.1} %",
                100.0 * error,
                100.0 * self.at_most
            ))),
            Ok(None) => Ok(Some("the model knows nothing of its error; train it again".into())),
            Err(Error::Start(message)) => Ok(Some(message)),
            Err(error) => Err(error),
        }
    }
}

impl Stepper for GuardedNetwork {
    fn name(&self) -> &'static str {
        self.network.name()
    }

    fn settings(&self) -> String {
        let accepted = 100.0 * self.at_most;
        format!("{}, {} where it may be off by more than {accepted} %", self.network.settings(), self.elements.name())
    }

    fn solves_friction(&self) -> bool {
        self.network.solves_friction()
    }

    fn knows_error(&self) -> bool {
        self.network.knows_error()
    }

    fn prepare(&self, world: &mut World) -> Result<()> {
        if let Some(reason) = self.doubt(world)? {
            self.network.withdraw(world);
            world.insert_resource(HandedOver(reason));
            self.elements.prepare(world)?;
        }
        Ok(())
    }

    fn register(&self, schedule: &mut Schedule, world: &mut World, model: &Model) {
        match world.contains_resource::<HandedOver>() {
            true => self.elements.register(schedule, world, model),
            false => self.network.register(schedule, world, model),
        }
    }
}
