//! A saved environment.

use super::draw::Key;
use serde::{Deserialize, Serialize};

/// An episode and what was done in it: as equal input gives equal output, replaying it leads to the same bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// The episode.
    pub key: Key,
    /// All actions since its start, one after the other.
    pub actions: Vec<f32>,
}
