//! Checkpoints, for going back on a loading path further than the last increment.

use super::Path;
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
}
