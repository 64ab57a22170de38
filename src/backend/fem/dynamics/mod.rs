//! Motion in time: terms of inertia, viscosity and drive for a time step, and the steps themselves.

pub mod advance;
pub mod integrator;
pub mod systems;
pub mod terms;
