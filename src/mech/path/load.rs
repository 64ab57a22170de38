//! Kinds of load.

/// Kind of load: how a level acts on solver and state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Load {
    /// The level is the force on every finger, N.
    Force,
    /// The level is the travel of every finger since the start, m.
    Travel,
    /// The level is the acting fraction of the push on the object.
    Push,
}
