//! Terms of the object alone, in addition to those of the pads.

use crate::contact::GroundContact;
use crate::potential::block::RigidBlock;
use crate::potential::point_load::PointLoad;
use crate::potential::rigid_inertia::RigidInertia;
use crate::potential::state::{NewtonStep, RigidUnknowns, State};
use crate::potential::term::{Assembly, ObjectTerm};
use crate::potential::time_step::TimeStep;
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};

/// Effects on the object alone; those that a scene does not need are None or empty. A new one takes a field, and a line
/// in `all` and `all_mut`.
#[derive(Debug, Clone, Default)]
pub struct ObjectTerms {
    /// Weight, or another constant force on the object on a quasi-static path.
    pub weight: Option<PointLoad>,
    /// Forces of a push.
    pub push: Vec<PointLoad>,
    /// Inertia and weight in a dynamic scene.
    pub inertia: Option<RigidInertia>,
    /// Contact with the ground.
    pub ground: Option<GroundContact>,
}

impl ObjectTerms {
    fn all(&self) -> impl Iterator<Item = &dyn ObjectTerm> {
        let dead = self.weight.iter().chain(&self.push).map(|t| t as &dyn ObjectTerm);
        dead.chain(self.inertia.iter().map(|t| t as _)).chain(self.ground.iter().map(|t| t as _))
    }

    fn all_mut(&mut self) -> impl Iterator<Item = &mut dyn ObjectTerm> {
        let dead = self.weight.iter_mut().chain(&mut self.push).map(|t| t as &mut dyn ObjectTerm);
        dead.chain(self.inertia.iter_mut().map(|t| t as _)).chain(self.ground.iter_mut().map(|t| t as _))
    }

    /// Sets the acting fraction of the push.
    pub fn set_push_fraction(&mut self, fraction: f64) {
        self.push.iter_mut().for_each(|force| force.fraction = fraction);
    }

    /// Energy of all terms, J.
    pub(crate) fn energy(&self, state: &State, rigid: &RigidUnknowns) -> f64 {
        let view = state.object_view(rigid);
        self.all().map(|t| t.energy(&view)).sum()
    }

    /// Adds gradient and Hessian of all terms to `block`.
    pub(crate) fn assemble(&mut self, state: &State, rigid: &RigidUnknowns, how: Assembly, block: &mut RigidBlock) {
        let view = state.object_view(rigid);
        self.all_mut().for_each(|t| t.assemble(&view, how, block));
    }

    /// Adds to `change` the change of the forces along `step` that the Hessian does not include.
    pub(crate) fn add_nonsymmetric_change(
        &self,
        state: &State,
        rigid: &RigidUnknowns,
        step: &NewtonStep,
        change: &mut RigidBlock,
    ) {
        let view = state.object_view(rigid);
        let motion = step.object_motion(&view);
        self.all().for_each(|t| t.add_nonsymmetric_change(&view, &motion, change));
    }

    /// Distance by which the object may move before anything touches, m.
    pub(crate) fn clearance(&self, state: &State, rigid: &RigidUnknowns) -> f64 {
        let view = state.object_view(rigid);
        self.all().map(|t| t.clearance(&view)).fold(f64::INFINITY, f64::min)
    }

    /// Begins a time step.
    pub(crate) fn begin_step(&mut self, step: &TimeStep) {
        self.inertia.iter_mut().for_each(|inertia| inertia.begin_step(step));
        self.ground.iter_mut().for_each(|ground| ground.begin_step(step));
    }

    /// Updates the history to an accepted state.
    pub(crate) fn commit(&mut self, state: &State, rigid: &RigidUnknowns) {
        let view = state.object_view(rigid);
        self.all_mut().for_each(|t| t.commit(&view));
    }

    /// Discards all changes since the last commit.
    pub(crate) fn rollback(&mut self) {
        self.all_mut().for_each(ObjectTerm::rollback);
    }

    /// Returns true if the converged state satisfies every term; all terms are evaluated.
    pub(crate) fn enforce_constraints(&mut self) -> bool {
        self.all_mut().filter_map(|t| (!t.enforce_constraints()).then_some(())).count() == 0
    }

    /// Writes the history of all terms.
    pub(crate) fn save_state(&self, history: &mut StateWriter) {
        self.all().for_each(|t| t.save_state(history));
    }

    /// Reads the history of the same terms.
    ///
    /// # Errors
    /// Fails if the history does not match these terms.
    pub(crate) fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        self.all_mut().try_for_each(|t| t.restore_state(history))
    }
}
