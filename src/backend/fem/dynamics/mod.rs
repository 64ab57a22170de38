//! Dynamics: inertia, viscosity and drive terms of a time step, and the time integration.

pub mod initial_guess;
pub mod integrator;
pub mod systems;
pub mod terms;
