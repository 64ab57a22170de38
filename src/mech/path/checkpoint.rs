//! Saved states of a path: checkpoints, which go back further than the last increment, and snapshots, from which
//! another process continues.

use super::methods::MethodCounts;
use super::pseudo_time::PseudoTime;
use super::step_size::StepSize;
use super::{Path, PathControl};
use crate::newton::SavedTerms;
use crate::potential::state::State;
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};
use serde::{Deserialize, Serialize};

/// Accepted state of a path with its history. Checkpoints and snapshots share this type, so that neither can lack a
/// part of it.
#[derive(Clone, Serialize, Deserialize)]
struct AcceptedState {
    state: State,
    level: f64,
    previous: Option<(State, f64)>,
    /// First load of the path, N or m.
    first_load: Option<f64>,
    /// Force along each driven travel, N.
    force: Vec<f64>,
    object_fixed: bool,
}

/// Work done on a path. Snapshots hold it; restoring a checkpoint does not undo it.
#[derive(Serialize, Deserialize)]
struct Work {
    step_size: StepSize,
    spent_iterations: u32,
    pseudo_time: PseudoTime,
    methods: MethodCounts,
    iterations: u64,
    projections: u64,
    frozen: u64,
}

/// Accepted state with the history of the path and of its solver's terms.
pub struct Checkpoint {
    accepted: AcceptedState,
    terms: SavedTerms,
}

impl Path {
    /// Returns the state and work to be saved. Every field of a path is named here: a new one belongs to the state, to
    /// the work, or to the settings that the caller makes before each level (`_`).
    fn saved_parts(&self) -> (AcceptedState, Work) {
        let Self {
            newton,
            state,
            level,
            previous,
            control,
            methods,
            pseudo_time,
            step_size,
            spent_iterations,
            tolerance: _,
            largest_drift: _,
            grasp_limits: _,
        } = self;
        let accepted = AcceptedState {
            state: state.clone(),
            level: *level,
            previous: previous.clone(),
            first_load: control.map(|control| control.first_load),
            force: newton.force.clone(),
            object_fixed: newton.object_fixed,
        };
        let profile = &newton.profile;
        let work = Work {
            step_size: *step_size,
            spent_iterations: *spent_iterations,
            pseudo_time: *pseudo_time,
            methods: *methods,
            iterations: profile.iterations,
            projections: profile.projections,
            frozen: profile.frozen,
        };
        (accepted, work)
    }

    fn restore_accepted(&mut self, accepted: AcceptedState) {
        let AcceptedState { state, level, previous, first_load, force, object_fixed } = accepted;
        (self.state, self.level, self.previous) = (state, level, previous);
        self.control = self.control.zip(first_load).map(|(control, first_load)| PathControl { first_load, ..control });
        (self.newton.force, self.newton.object_fixed) = (force, object_fixed);
    }

    /// Saves the state that [`Path::restore`] restores.
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint { accepted: self.saved_parts().0, terms: self.newton.save_terms() }
    }

    /// Discards all changes since `checkpoint`.
    pub fn restore(&mut self, checkpoint: Checkpoint) {
        self.restore_accepted(checkpoint.accepted);
        self.newton.restore_terms(checkpoint.terms);
    }

    /// Writes everything that the next increment depends on.
    pub fn save_state(&self, history: &mut StateWriter) {
        history.write(&self.saved_parts());
        self.newton.save_state(history);
    }

    /// Reads the data of [`Path::save_state`] into a path with the same bodies and terms.
    ///
    /// # Errors
    /// Fails if the history does not match this path.
    pub fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        let (accepted, work): (AcceptedState, Work) = history.read()?;
        self.restore_accepted(accepted);
        let Work { step_size, spent_iterations, pseudo_time, methods, iterations, projections, frozen } = work;
        (self.step_size, self.spent_iterations, self.pseudo_time, self.methods) =
            (step_size, spent_iterations, pseudo_time, methods);
        let profile = &mut self.newton.profile;
        (profile.iterations, profile.projections, profile.frozen) = (iterations, projections, frozen);
        self.newton.restore_state(history)
    }
}
