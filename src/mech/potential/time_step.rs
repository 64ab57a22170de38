//! Motion in time: backward Euler as an incremental potential, beside the quasi-static path.
//!
//! A time step from `t` to `t + h` minimises, over the state at its end,
//!
//! ```text
//! elastic + contact + friction + ground        the terms of a quasi-static increment, unchanged
//!   + m / 2 h2 |x - (x0 + h v0 + h2 g)|2       pad_inertia.rs, rigid_inertia.rs (rotation: Moser & Veselov 1991)
//!   + viscosity, drive                         viscosity.rs, drive.rs
//!   - force x travel
//! ```
//!
//! The hand is prescribed and everything is written in its frame at the end of the step: inertia compares positions in the
//! world, so that it feels the hand accelerate, and nothing else does. Gravity acts on masses and so stands with them.
//!
//! Backward Euler conserves linear momentum, the rotation conserves angular momentum, both to the solver's tolerance;
//! energy of oscillations is lost at a rate that falls with the step (first order), energy of free flight and free spin is
//! not. Errors of positions are of first order: a free fall is off by `g h t / 2`.

use crate::scene::motion::HandState;

/// A time step, as the terms see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeStep {
    /// Length of the step, s.
    pub size: f64,
    /// State of the hand at its end.
    pub hand: HandState,
}
