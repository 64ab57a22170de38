//! Pseudo-time: proximal springs from the accepted state to the next one, which bound the motion of one step.
//!
//! An object that rolls or slides passes through states that are not equilibria. A step with springs is an implicit
//! step of gradient descent (pseudo-transient continuation: Kelley and Keyes 1998): it has a solution near the previous
//! state under any load. The stiffness adapts to the steps: softer after an easy one, stiffer after one that moved too
//! far or failed, none once the force of the springs is within the tolerance of the out-of-balance forces.

use crate::newton::NewtonTolerance;
use crate::newton::proximal::ProximalSprings;
use crate::potential::state::State;
use base::scales::{FIRST_PSEUDO_STEP, LARGEST_PSEUDO_STEP};
use serde::{Deserialize, Serialize};

/// Loose tolerance, of intermediate states, over the tight one, of results.
pub(crate) const LOOSE_TOLERANCE_FACTOR: f64 = 20.0;
/// Maximum number of iterations of one step with springs.
const SPRING_STEP_ITERATIONS: u32 = 25;
/// Stiffness of the springs of the nodes over those of the rigid unknowns.
const NODE_STIFFNESS_RATIO: f64 = 0.3;
/// Out-of-balance force that a step may leave, over the force of its springs; and force of the springs at equilibrium,
/// over the admissible out-of-balance force.
const SPRING_FORCE_RATIO: f64 = 0.3;
/// Number of iterations from which a step is no longer easy, and from which it is hard.
const EASY_STEP_ITERATIONS: u32 = 8;
const HARD_STEP_ITERATIONS: u32 = 15;
/// Factors of the stiffness after an easy step and after a moderate one; and after one that moved too far and one that
/// failed.
const SOFTENING_FACTORS: [f64; 2] = [0.25, 0.5];
const STIFFENING_FACTORS: [f64; 2] = [2.0, 8.0];
/// Lower bound of the stiffness after a step that failed, over that of its own, and the factor by which the bound
/// decreases with every accepted step.
const STIFFNESS_BOUND_RATIO: f64 = 3.0;
const STIFFNESS_BOUND_DECAY: f64 = 0.7;
/// Force of the springs over the load above which the load is held constant.
const LOAD_HOLD_FORCE_RATIO: f64 = 0.02;

/// State of the springs.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct PseudoTime {
    /// Stiffness of the springs of the rigid unknowns, N/m; zero without springs.
    stiffness: f64,
    /// Lower bound of the stiffness of the next steps, N/m: springs as soft as those of a failed step are not tried
    /// again soon.
    min_stiffness: f64,
    /// Stiffness of the last springs, N/m.
    last_stiffness: f64,
    /// Tolerance of the next step over that of a result.
    tolerance_factor: f64,
    /// Flag: the force of the springs is so large that the load is held constant.
    pub holds_load: bool,
}

/// Outcome of a step.
pub(crate) struct PseudoStep {
    /// Newton iterations.
    pub iterations: u32,
    /// Motion of the rigid unknowns, m.
    pub motion: f64,
    /// Force of the springs, N.
    pub spring_force: f64,
}

impl PseudoTime {
    /// No springs.
    pub const NONE: Self =
        Self { stiffness: 0.0, min_stiffness: 0.0, last_stiffness: 0.0, tolerance_factor: 1.0, holds_load: false };

    /// Returns true if the next step has springs.
    pub fn is_on(&self) -> bool {
        self.stiffness > 0.0
    }

    /// Springs of the next step, from `state`.
    pub fn springs(&self, state: &State) -> Option<ProximalSprings> {
        let springs = || ProximalSprings {
            center: state.clone(),
            rigid_stiffness: self.stiffness,
            node_stiffness: NODE_STIFFNESS_RATIO * self.stiffness,
        };
        self.is_on().then(springs)
    }

    /// Tolerance of the next step, if that of a result is `full`.
    pub fn tolerance(&self, full: &NewtonTolerance) -> NewtonTolerance {
        let iterations = if self.is_on() { full.iterations.min(SPRING_STEP_ITERATIONS) } else { full.iterations };
        let (relative, force) = (self.tolerance_factor * full.relative, self.tolerance_factor * full.force);
        NewtonTolerance { relative, force, iterations, intermediate: self.tolerance_factor > 1.0, ..*full }
    }

    /// Returns true if the state after a step with `spring_force` (N) is an equilibrium, where forces of up to
    /// `floor` (N) may be out of balance.
    pub fn is_equilibrium(&self, spring_force: f64, floor: f64) -> bool {
        self.tolerance_factor == 1.0 && spring_force <= SPRING_FORCE_RATIO * floor
    }

    /// Updates the springs after an accepted step under `load` (N). The load has changed in the step if it was
    /// `loaded`.
    pub fn accept(&mut self, moved: &PseudoStep, load: f64, floor: f64, full: &NewtonTolerance, loaded: bool) {
        if !self.is_on() {
            return;
        }
        self.last_stiffness = self.stiffness;
        if self.is_equilibrium(moved.spring_force, floor) && loaded {
            *self = Self { last_stiffness: self.last_stiffness, ..Self::NONE };
            return;
        }
        let reach = LARGEST_PSEUDO_STEP * full.offset;
        self.holds_load = moved.spring_force > LOAD_HOLD_FORCE_RATIO * load;
        self.tolerance_factor = (SPRING_FORCE_RATIO * moved.spring_force / floor).clamp(1.0, LOOSE_TOLERANCE_FACTOR);
        self.min_stiffness *= STIFFNESS_BOUND_DECAY;
        if moved.iterations < HARD_STEP_ITERATIONS && moved.motion < 0.5 * reach {
            let softer = SOFTENING_FACTORS[usize::from(moved.iterations >= EASY_STEP_ITERATIONS)];
            self.stiffness = (self.stiffness * softer).max(self.min_stiffness.min(self.stiffness));
        } else if moved.motion > reach {
            self.stiffness *= STIFFENING_FACTORS[0];
        }
    }

    /// Updates the springs after a failed step under `load` (N).
    pub fn reject(&mut self, load: f64, full: &NewtonTolerance) {
        if self.is_on() {
            self.min_stiffness = STIFFNESS_BOUND_RATIO * self.stiffness;
            self.stiffness *= STIFFENING_FACTORS[1];
            self.tolerance_factor = (2.0 * self.tolerance_factor).min(LOOSE_TOLERANCE_FACTOR);
        } else {
            self.stiffness = if self.last_stiffness > 0.0 {
                STIFFENING_FACTORS[0] * self.last_stiffness
            } else {
                load / (FIRST_PSEUDO_STEP * full.offset)
            };
            self.tolerance_factor = LOOSE_TOLERANCE_FACTOR;
        }
    }
}
