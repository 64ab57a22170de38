//! Interface of the backends: systems in [`StepSet::Advance`](crate::schedule::StepSet::Advance) (and the
//! adjacent sets) that bring the components of [`crate::components`] to the load of the step.
//!
//! In a step where [`Phase`](crate::schedule::Phase) is `Ramp`, a stepper must either read `StepLoad::level` and
//! write `Position`, `FingerTravel`, `ObjectPose`, `FingerWrench`, the stress and force columns that exist, the contact
//! edges if it has any (the network has only nodal forces), and all of
//! [`StepReport`](crate::schedule::StepReport) with `reached = true`; or leave the last accepted state in place
//! and request `Phase::Fault`, `Phase::Dropped`, or the `Phase::Ramp` of a later frame if it cannot compute this one.

use base::error::Result;
use base::saved_state::{StateReader, StateWriter};
use bevy_ecs::schedule::Schedule;
use bevy_ecs::world::World;
use model::Model;
use scene::Scene;
use std::sync::Arc;

/// Backend.
pub trait Stepper: std::fmt::Debug + Send + Sync {
    /// Returns its name in reports: `fem`, `gnn`.
    fn name(&self) -> &'static str;
    /// Returns its settings in one line, for reports.
    fn settings(&self) -> String;
    /// Returns true if it computes whether friction holds the object; if not, the environment (`env::slip`) decides
    /// that.
    fn solves_friction(&self) -> bool {
        true
    }
    /// Returns true if its frames have an error bound.
    fn has_error_bound(&self) -> bool {
        false
    }
    /// Returns notices on the validity of its results for `model`, one sentence each.
    fn notices(&self, _model: &Model) -> Vec<String> {
        Vec::new()
    }
    /// Checks that the backend supports `model`, before anything of a run is written.
    ///
    /// # Errors
    /// Fails if it does not; the message states the reason.
    fn check_support(&self, _model: &Arc<Model>) -> Result<()> {
        Ok(())
    }
    /// Returns true if the systems that it registers depend on the grasp: a world is not reused then.
    fn systems_depend_on_grasp(&self) -> bool {
        false
    }
    /// Inserts its resources into `world`, at the start of a grasp.
    ///
    /// # Errors
    /// Fails if the backend does not support the world's scene.
    fn prepare(&self, world: &mut World) -> Result<()>;
    /// Adds its systems to `schedule`, and the entities that only it needs to the `world` of `model`.
    fn register(&self, schedule: &mut Schedule, world: &mut World, model: &Model);
    /// Writes what the next step depends on in addition to the columns of `world`.
    fn save_state(&self, _world: &World, _history: &mut StateWriter) {}
    /// Reads what [`Stepper::save_state`] wrote, into a world that was prepared for the same grasp and whose columns
    /// are restored.
    ///
    /// # Errors
    /// Fails if the history does not match.
    fn restore_state(&self, _world: &mut World, _history: &mut StateReader) -> Result<()> {
        Ok(())
    }
}

/// Function that opens the backend that a scene selects.
pub type StepperFactory = fn(&Scene) -> Result<Box<dyn Stepper>>;
