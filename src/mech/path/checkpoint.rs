//! What a path remembers: kept whole to go back further than the last increment, and written whole to go on in another process.

use super::continuation::Methods;
use super::pseudo_time::PseudoTime;
use super::step_size::StepSize;
use super::{Path, PathControl};
use crate::error::Result;
use crate::history::{HistoryReader, HistoryWriter};
use crate::mech::newton::SavedTerms;
use crate::mech::potential::state::State;
use serde::{Deserialize, Serialize};

/// Accepted state of a path with all that led to it. Checkpoints and snapshots both hold it, so that neither can lack a part of it.
#[derive(Clone, Serialize, Deserialize)]
struct Accepted {
    state: State,
    level: f64,
    history: Option<(State, f64)>,
    /// Load with which the path begins, N or m.
    first: Option<f64>,
    /// Force along each driven travel, N.
    force: Vec<f64>,
    object_fixed: bool,
}

/// Work done on a path, which going back does not undo. Snapshots hold it, too.
#[derive(Serialize, Deserialize)]
struct Work {
    step: StepSize,
    spent: u32,
    pseudo_time: PseudoTime,
    methods: Methods,
    iterations: u64,
    projections: u64,
    frozen: u64,
}

/// An accepted state with all that the path and the terms of its solver remember.
pub struct Checkpoint {
    accepted: Accepted,
    terms: SavedTerms,
}

impl Path {
    /// Returns what the path remembers. Every field of a path is named here: a new one belongs to the state, to the work, or to
    /// the settings that the caller gives before each level (`_`).
    fn remembered(&self) -> (Accepted, Work) {
        let Self {
            newton,
            state,
            level,
            history,
            control,
            methods,
            pseudo_time,
            step,
            spent,
            tolerance: _,
            largest_drift: _,
            place: _,
        } = self;
        let accepted = Accepted {
            state: state.clone(),
            level: *level,
            history: history.clone(),
            first: control.map(|control| control.first),
            force: newton.force.clone(),
            object_fixed: newton.object_fixed,
        };
        let profile = &newton.profile;
        let work = Work {
            step: *step,
            spent: *spent,
            pseudo_time: *pseudo_time,
            methods: *methods,
            iterations: profile.iterations,
            projections: profile.projections,
            frozen: profile.frozen,
        };
        (accepted, work)
    }

    fn accept(&mut self, accepted: Accepted) {
        let Accepted { state, level, history, first, force, object_fixed } = accepted;
        (self.state, self.level, self.history) = (state, level, history);
        self.control = self.control.zip(first).map(|(control, first)| PathControl { first, ..control });
        (self.newton.force, self.newton.object_fixed) = (force, object_fixed);
    }

    /// Saves the state that [`Path::restore`] goes back to.
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint { accepted: self.remembered().0, terms: self.newton.save() }
    }

    /// Forgets what happened since `checkpoint`.
    pub fn restore(&mut self, checkpoint: Checkpoint) {
        self.accept(checkpoint.accepted);
        self.newton.restore(checkpoint.terms);
    }

    /// Writes all that the next increment depends on.
    pub fn write_history(&self, history: &mut HistoryWriter) {
        history.write(&self.remembered());
        self.newton.write_history(history);
    }

    /// Reads what [`Path::write_history`] wrote, into a path with the same bodies and terms.
    ///
    /// # Errors
    /// Fails for a history of something else.
    pub fn read_history(&mut self, history: &mut HistoryReader) -> Result<()> {
        let (accepted, work): (Accepted, Work) = history.read()?;
        self.accept(accepted);
        let Work { step, spent, pseudo_time, methods, iterations, projections, frozen } = work;
        (self.step, self.spent, self.pseudo_time, self.methods) = (step, spent, pseudo_time, methods);
        let profile = &mut self.newton.profile;
        (profile.iterations, profile.projections, profile.frozen) = (iterations, projections, frozen);
        self.newton.read_history(history)
    }
}
