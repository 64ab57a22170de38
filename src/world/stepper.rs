//! The interface of the backends: systems in [`StepSet::Advance`](crate::world::schedule::StepSet::Advance) (and the sets
//! around it) that bring the components of [`crate::world::components`] to the load of the step.
//!
//! A stepper must, in a step where [`Phase`](crate::world::schedule::Phase) is `Ramp`: read `StepLoad::level`, write `Position`,
//! `FingerTravel`, `ObjectPose`, `FingerWrench`, the stress and force columns that exist, the contact edges if it has any
//! (the network knows forces on nodes, not between points), and all of
//! [`StepReport`](crate::world::schedule::StepReport) with `reached = true`; or leave the last accepted state in place and request
//! `Phase::Fault`, or the `Phase::Ramp` of a later frame if it has no answer to this one.

use crate::error::Result;
use crate::history::{HistoryReader, HistoryWriter};
use crate::model::Model;
use crate::scene::Scene;
use bevy_ecs::schedule::Schedule;
use bevy_ecs::world::World;

/// A backend.
pub trait Stepper: std::fmt::Debug + Send + Sync {
    /// Its name in reports: `fem`, `gnn`.
    fn name(&self) -> &'static str;
    /// Its settings in one line, for reports.
    fn settings(&self) -> String;
    /// Returns true if friction may fail to hold an object in it; if not, [`crate::env::slip`] judges that.
    fn solves_friction(&self) -> bool {
        true
    }
    /// Returns true if its frames come with their error.
    fn knows_error(&self) -> bool {
        false
    }
    /// Returns what to know about its results for `model` before they are trusted, a sentence each.
    fn notices(&self, _model: &Model) -> Vec<String> {
        Vec::new()
    }
    /// Checks that the backend serves `model`, before anything of it is written.
    ///
    /// # Errors
    /// Fails if it does not; the message says why.
    fn admit(&self, _model: &Model) -> Result<()> {
        Ok(())
    }
    /// Returns true if the grasp decides which systems it registers: no world is used again then.
    fn chooses_systems(&self) -> bool {
        false
    }
    /// Puts its resources into `world`, at the start of a grasp.
    ///
    /// # Errors
    /// Fails if the backend cannot serve the world's scene.
    fn prepare(&self, world: &mut World) -> Result<()>;
    /// Puts its systems into `schedule`, and the entities that it alone needs into the `world` of `model`.
    fn register(&self, schedule: &mut Schedule, world: &mut World, model: &Model);
    /// Writes what the next step depends on beside the columns of `world`.
    fn write_history(&self, _world: &World, _history: &mut HistoryWriter) {}
    /// Reads what [`Stepper::write_history`] wrote, into a world prepared for the same grasp whose columns are those of then.
    ///
    /// # Errors
    /// Fails for a history of something else.
    fn read_history(&self, _world: &mut World, _history: &mut HistoryReader) -> Result<()> {
        Ok(())
    }
}

/// Function that opens the backend which a scene names.
pub type Choose = fn(&Scene) -> Result<Box<dyn Stepper>>;
