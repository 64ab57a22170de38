//! Finite elements: bodies, the terms of the incremental potential, and the Newton solver that minimises their sum.

mod analysis;
pub mod arrow;
pub mod body;
pub mod checkpoint;
pub mod cholesky;
pub mod condensed;
mod direction;
pub mod dynamics;
pub mod effort;
pub mod increment;
mod lagging;
mod level;
pub mod locking;
pub mod newton;
pub mod pattern;
pub mod proximal;
pub mod readout;
mod solve;
pub mod state;
pub mod stepper;
pub mod systems;
pub mod term;
pub mod upright;
mod walk;
pub mod weight;
mod whole;
