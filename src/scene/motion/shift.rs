//! To another place.

use super::{HandState, Play, Stage, smooth};
use crate::scene::leaf::Seconds;
use crate::scene::vector::Vec3;
use serde::{Deserialize, Serialize};

/// Moves by a vector, starting and ending at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Move {
    /// World axes, m.
    pub by: Vec3,
    /// s.
    pub duration: Seconds,
}

impl Play for Move {
    fn duration(&self) -> f64 {
        self.duration.get()
    }

    fn hand(&self, start: &HandState, time: f64, _: &Stage) -> HandState {
        let by = self.by.dvec3() * smooth(time / self.duration());
        HandState { position: start.position + by, ..*start }
    }
}
