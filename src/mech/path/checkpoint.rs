//! Checkpoints, for going back on a loading path further than the last increment, and bytes, for going on in another process.

use super::{Path, PathControl};
use crate::error::Result;
use crate::history::{HistoryReader, HistoryWriter};
use crate::mech::newton::SavedTerms;
use crate::mech::potential::state::State;

/// An accepted state with all that the path remembers.
pub struct Checkpoint {
    state: State,
    level: f64,
    history: Option<(State, f64)>,
    terms: SavedTerms,
    force: Vec<f64>,
}

impl Checkpoint {
    /// The accepted state.
    pub fn state(&self) -> &State {
        &self.state
    }
}

impl Path {
    /// Saves the state that [`Path::restore`] goes back to.
    pub fn checkpoint(&self) -> Checkpoint {
        Checkpoint {
            state: self.state.clone(),
            level: self.level,
            history: self.history.clone(),
            terms: self.newton.save(),
            force: self.newton.force.clone(),
        }
    }

    /// Forgets what happened since `checkpoint`.
    pub fn restore(&mut self, checkpoint: Checkpoint) {
        (self.state, self.level, self.history) = (checkpoint.state, checkpoint.level, checkpoint.history);
        self.newton.restore(checkpoint.terms);
        self.newton.force = checkpoint.force;
        self.at_once = false;
    }

    /// Writes all that the next increment depends on.
    pub fn write_history(&self, history: &mut HistoryWriter) {
        history.write(&(&self.state, self.level, &self.history));
        history.write(&(self.step, self.spent, self.at_once, self.methods));
        history.write(&self.control.map(|control| control.first));
        let newton = &self.newton;
        history.write(&(&newton.force, newton.object_fixed, newton.profile.iterations));
        history.write(&(newton.profile.projections, newton.profile.frozen));
        newton.write_history(history);
    }

    /// Reads what [`Path::write_history`] wrote, into a path with the same bodies and terms.
    ///
    /// # Errors
    /// Fails for a history of something else.
    pub fn read_history(&mut self, history: &mut HistoryReader) -> Result<()> {
        (self.state, self.level, self.history) = history.read()?;
        (self.step, self.spent, self.at_once, self.methods) = history.read()?;
        let first: Option<f64> = history.read()?;
        self.control = self.control.zip(first).map(|(control, first)| PathControl { first, ..control });
        let newton = &mut self.newton;
        (newton.force, newton.object_fixed, newton.profile.iterations) = history.read()?;
        (newton.profile.projections, newton.profile.frozen) = history.read()?;
        newton.read_history(history)
    }
}
