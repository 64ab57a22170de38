//! Wait.

use super::{HandState, Play, Stage};
use crate::scene::leaf::Seconds;
use serde::{Deserialize, Serialize};

/// Stays where it is, with the force it has.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hold {
    /// s.
    pub duration: Seconds,
}

impl Play for Hold {
    fn duration(&self) -> f64 {
        self.duration.get()
    }

    fn hand(&self, start: &HandState, _: f64, _: &Stage) -> HandState {
        *start
    }
}
