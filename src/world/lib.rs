//! World of a grasp: components, the schedule of a step, and the systems common to all steppers.

pub mod components;
pub mod environment;
pub mod run;
pub mod schedule;
pub mod snapshot;
pub mod spawn;
pub mod stepper;
pub mod systems;

pub use environment::Environment;
pub use stepper::{Stepper, StepperFactory};
