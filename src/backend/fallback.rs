//! Guarded network: grasps outside its training range or with too large a predicted error go to finite elements.

use super::fem::stepper::FemStepper;
use super::network::NetworkStepper;
use base::error::{Error, Result};
use base::saved_state::{StateReader, StateWriter};
use bevy_ecs::prelude::*;
use model::Model;
use scene::{Condensed, Fem, Solver};
use world::Stepper;
use world::schedule::{FallbackReason, SharedModel};

/// Network that falls back to condensed finite elements where its predicted error is too large or unknown.
#[derive(Debug)]
pub struct NetworkWithFallback {
    network: NetworkStepper,
    finite_elements: FemStepper,
    /// Largest accepted predicted error of the displacement, as a fraction.
    max_error: f64,
}

impl NetworkWithFallback {
    /// Creates the stepper that falls back where the predicted error of `network` exceeds `max_error`.
    pub fn new(network: NetworkStepper, max_error: f64) -> Self {
        let elements = Fem { solver: Solver::Condensed(Condensed::default()), ..Fem::default() };
        Self { network, finite_elements: FemStepper::new(&elements), max_error }
    }

    /// Returns the stepper that computes the grasp of a prepared world.
    fn active_stepper(&self, world: &World) -> &dyn Stepper {
        match world.contains_resource::<FallbackReason>() {
            true => &self.finite_elements,
            false => &self.network,
        }
    }

    /// Returns the reason why the network must not compute this grasp; None if it may.
    fn fallback_reason(&self, world: &mut World) -> Result<Option<String>> {
        let model = world.get_resource::<SharedModel>().map(|shared| shared.0.clone());
        if let Some(reason) = model.as_ref().and_then(|model| self.network.reason_outside_range(model)) {
            return Ok(Some(format!("the network was not trained for all loads: {reason}")));
        }
        match self.network.prepare(world).and_then(|()| self.network.predict_all_loads(world)) {
            Ok(error) if error <= self.max_error => Ok(None),
            Ok(error) if error.is_infinite() => {
                let why = model.map(|model| self.network.notices(&model).join("; "));
                Ok(Some(why.unwrap_or_else(|| "the error of the network is unknown".into())))
            }
            Ok(error) => Ok(Some(format!(
                "the displacement error of nine of ten such predictions is at most {:.1} %; accepted are {:.1} %",
                100.0 * error,
                100.0 * self.max_error
            ))),
            Err(Error::Start(message)) => Ok(Some(message)),
            Err(error) => Err(error),
        }
    }
}

impl Stepper for NetworkWithFallback {
    fn name(&self) -> &'static str {
        self.network.name()
    }

    fn settings(&self) -> String {
        let accepted = 100.0 * self.max_error;
        format!(
            "{}, {} where its error bound exceeds {accepted} %",
            self.network.settings(),
            self.finite_elements.name()
        )
    }

    fn solves_friction(&self) -> bool {
        self.network.solves_friction()
    }

    fn has_error_bound(&self) -> bool {
        self.network.has_error_bound()
    }

    fn systems_depend_on_grasp(&self) -> bool {
        true
    }

    fn prepare(&self, world: &mut World) -> Result<()> {
        if let Some(reason) = self.fallback_reason(world)? {
            self.network.remove_resources(world);
            world.insert_resource(FallbackReason(reason));
            self.finite_elements.prepare(world)?;
        }
        Ok(())
    }

    fn register(&self, schedule: &mut Schedule, world: &mut World, model: &Model) {
        self.active_stepper(world).register(schedule, world, model);
    }

    fn save_state(&self, world: &World, history: &mut StateWriter) {
        history.write(&world.contains_resource::<FallbackReason>());
        self.active_stepper(world).save_state(world, history);
    }

    fn restore_state(&self, world: &mut World, history: &mut StateReader) -> Result<()> {
        let fell_back: bool = history.read()?;
        if fell_back != world.contains_resource::<FallbackReason>() {
            let [saved, own] =
                [fell_back, !fell_back].map(|elements| if elements { "finite elements" } else { "the network" });
            return Err(Error::Start(format!(
                "the saved grasp was computed by {saved}, but here it would be computed by {own}: it belongs to \
                 another scene, model or version"
            )));
        }
        self.active_stepper(world).restore_state(world, history)
    }
}
