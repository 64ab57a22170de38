//! Finite element backend: the solver of a grasp, and its systems in the schedule of a step.

pub mod condensed;
pub mod dynamics;
mod full_pads;
mod level;
mod solver;
pub mod stepper;
pub mod systems;
