//! Finite element backend as a stage of the schedule.

use super::dynamics::integrator::Integrator;
pub use super::solver::GraspSolver;
use super::systems;
use base::error::{Error, Result};
use base::saved_state::{StateReader, StateWriter};
use bevy_ecs::prelude::*;
use model::Model;
use world::Stepper;
use world::schedule::{GraspPose, SharedModel};
use world::spawn::spawn_edges;

/// Finite element backend, with the settings of a scene.
#[derive(Debug, Clone, Copy)]
pub struct FemStepper {
    settings: scene::Fem,
}

impl FemStepper {
    /// Creates the backend with the finite element settings of a scene.
    pub fn new(settings: &scene::Fem) -> Self {
        Self { settings: *settings }
    }
}

impl Stepper for FemStepper {
    fn name(&self) -> &'static str {
        "fem"
    }

    fn settings(&self) -> String {
        let s = &self.settings;
        let element = match (s.element, s.mean_dilatation) {
            (scene::Element::Linear, _) => "linear",
            (scene::Element::Quadratic, true) => "quadratic, mean dilatation",
            (scene::Element::Quadratic, false) => "quadratic",
        };
        let pads = match s.solver {
            scene::Solver::Full => String::new(),
            scene::Solver::Condensed(c) => format!(", condensed to an error of {:e}", c.error.get()),
        };
        format!("{element}, force tolerance {:e}{pads}", s.tolerance.force.get())
    }

    fn notices(&self, model: &Model) -> Vec<String> {
        let scene::Solver::Condensed(c) = self.settings.solver else { return Vec::new() };
        let notice = format!(
            "pads are condensed to an error of {:e} while the object is fixed; after its release at {:.4} N per finger \
             their error is not checked, and may be as large as their displacement if the object rolls or slides. \
             `solver: Full` avoids this error",
            c.error.get(),
            model.release
        );
        model.is_released_later().then_some(notice).into_iter().collect()
    }

    fn prepare(&self, world: &mut World) -> Result<()> {
        let missing = || Error::Start("the world was not created for a grasp".into());
        let shared = world.get_resource::<SharedModel>().ok_or_else(missing)?.clone();
        let grasp = *world.get_resource::<GraspPose>().ok_or_else(missing)?;
        let pose = grasp.0.inverse();
        world.insert_resource(GraspSolver::new(&shared.0, pose, &self.settings)?);
        world.insert_resource(systems::EdgeReadings::default());
        if let Some(dynamics) = &shared.0.dynamics {
            world.insert_resource(Integrator::new(dynamics, grasp.0));
        }
        Ok(())
    }

    fn register(&self, schedule: &mut Schedule, world: &mut World, model: &Model) {
        spawn_edges(world, model);
        systems::register(schedule, &model.needs, model.force_driven);
    }

    fn save_state(&self, world: &World, history: &mut StateWriter) {
        if let Some(integrator) = world.get_resource::<Integrator>() {
            integrator.save_state(history);
        }
        if let Some(solver) = world.get_resource::<GraspSolver>() {
            solver.save_state(history);
        }
    }

    fn restore_state(&self, world: &mut World, history: &mut StateReader) -> Result<()> {
        let missing = || Error::Start("the world was not prepared for finite elements".into());
        let model = world.get_resource::<SharedModel>().ok_or_else(missing)?.0.clone();
        let mut solver = world.remove_resource::<GraspSolver>().ok_or_else(missing)?;
        if let (Some(mut integrator), Some(dynamics)) = (world.get_resource_mut::<Integrator>(), &model.dynamics) {
            integrator.restore_state(&mut solver.path, &model, dynamics, &self.settings, history)?;
        }
        let read = solver.restore_state(&model, history);
        world.insert_resource(solver);
        read
    }
}
