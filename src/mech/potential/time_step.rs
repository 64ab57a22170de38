//! Dynamics: backward Euler as an incremental potential, in addition to the quasi-static path.
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
//! The motion of the hand is prescribed, and all positions are in its frame at the end of the step. Inertia compares
//! positions in the world and is the only effect that depends on the acceleration of the hand. Gravity acts on masses
//! and is part of the inertia terms.
//!
//! Backward Euler conserves linear momentum, the rotation conserves angular momentum, both to the solver's tolerance.
//! Energy of oscillations is dissipated at a rate that decreases with the step (first order); energy of free flight and
//! free rotation is not. Errors of positions are of first order: a free fall is off by `g h t / 2`.

use geometry::Pose;

/// Time step, as passed to the terms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeStep {
    /// Length of the step, s.
    pub size: f64,
    /// State of the hand at its end.
    pub hand: Pose,
}
