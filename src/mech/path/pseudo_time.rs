//! Pseudo-time: proximal springs from the accepted state to the next one, which bound the motion of one step.
//!
//! An object that rolls or slides passes through states that are not equilibria. A step with springs is an implicit
//! step of gradient descent (pseudo-transient continuation: Kelley and Keyes 1998): it has a solution near the previous
//! state under any load. The stiffness adapts to the steps: softer after an easy one, stiffer after one that moved too
//! far or failed, none once the force of the springs is within the tolerance of the out-of-balance forces.

use crate::newton::NewtonTolerance;
use crate::newton::proximal::Proximal;
use crate::potential::state::State;
use base::scales::{FIRST_PSEUDO_STEP, LARGEST_PSEUDO_STEP};
use serde::{Deserialize, Serialize};

/// Loose tolerance, of intermediate states, over the tight one, of results.
pub(crate) const LOOSE: f64 = 20.0;
/// Maximum number of iterations of one step with springs.
const STEP_ITERATIONS: u32 = 25;
/// Stiffness of the springs of the nodes over those of the rigid unknowns.
const NODES: f64 = 0.3;
/// Out-of-balance force that a step may leave, over the force of its springs; and force of the springs at equilibrium,
/// over the admissible out-of-balance force.
const FOLLOWED: f64 = 0.3;
/// Number of iterations from which a step is no longer easy, and from which it is hard.
const EASY: u32 = 8;
const HARD: u32 = 15;
/// Factors of the stiffness after an easy step and after a moderate one; and after one that moved too far and one that
/// failed.
const SOFTER: [f64; 2] = [0.25, 0.5];
const STIFFER: [f64; 2] = [2.0, 8.0];
/// Lower bound of the stiffness after a step that failed, over that of its own, and the factor by which the bound
/// decreases with every accepted step.
const WARY: f64 = 3.0;
const FORGETTING: f64 = 0.7;
/// Force of the springs over the load above which the load is held constant.
const WAITS: f64 = 0.02;

/// State of the springs.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct PseudoTime {
    /// Stiffness of the springs of the rigid unknowns, N/m; zero without springs.
    stiffness: f64,
    /// Lower bound of the stiffness of the next steps, N/m: springs as soft as those of a failed step are not tried
    /// again soon.
    softest: f64,
    /// Stiffness of the last springs, N/m.
    last: f64,
    /// Tolerance of the next step over that of a result.
    slack: f64,
    /// Flag: the force of the springs is so large that the load is held constant.
    pub waits: bool,
}

/// Outcome of a step.
pub(crate) struct PseudoStep {
    /// Newton iterations.
    pub iterations: u32,
    /// Motion of the rigid unknowns, m.
    pub way: f64,
    /// Force of the springs, N.
    pub pull: f64,
}

impl PseudoTime {
    /// No springs.
    pub const NONE: Self = Self { stiffness: 0.0, softest: 0.0, last: 0.0, slack: 1.0, waits: false };

    /// Returns true if the next step has springs.
    pub fn is_on(&self) -> bool {
        self.stiffness > 0.0
    }

    /// Springs of the next step, from `state`.
    pub fn springs(&self, state: &State) -> Option<Proximal> {
        let springs = || Proximal { center: state.clone(), rigid: self.stiffness, nodes: NODES * self.stiffness };
        self.is_on().then(springs)
    }

    /// Tolerance of the next step, if that of a result is `full`.
    pub fn tolerance(&self, full: &NewtonTolerance) -> NewtonTolerance {
        let iterations = if self.is_on() { full.iterations.min(STEP_ITERATIONS) } else { full.iterations };
        let (relative, force) = (self.slack * full.relative, self.slack * full.force);
        NewtonTolerance { relative, force, iterations, passing: self.slack > 1.0, ..*full }
    }

    /// Returns true if the state after a step with spring force `pull` (N) is an equilibrium, where forces of up to
    /// `floor` (N) may be out of balance.
    pub fn rests(&self, pull: f64, floor: f64) -> bool {
        self.slack == 1.0 && pull <= FOLLOWED * floor
    }

    /// Updates the springs after an accepted step under `load` (N). The load has changed in the step if it was
    /// `loaded`.
    pub fn accept(&mut self, moved: &PseudoStep, load: f64, floor: f64, full: &NewtonTolerance, loaded: bool) {
        if !self.is_on() {
            return;
        }
        self.last = self.stiffness;
        if self.rests(moved.pull, floor) && loaded {
            *self = Self { last: self.last, ..Self::NONE };
            return;
        }
        let reach = LARGEST_PSEUDO_STEP * full.offset;
        self.waits = moved.pull > WAITS * load;
        self.slack = (FOLLOWED * moved.pull / floor).clamp(1.0, LOOSE);
        self.softest *= FORGETTING;
        if moved.iterations < HARD && moved.way < 0.5 * reach {
            let softer = SOFTER[usize::from(moved.iterations >= EASY)];
            self.stiffness = (self.stiffness * softer).max(self.softest.min(self.stiffness));
        } else if moved.way > reach {
            self.stiffness *= STIFFER[0];
        }
    }

    /// Updates the springs after a failed step under `load` (N).
    pub fn refuse(&mut self, load: f64, full: &NewtonTolerance) {
        if self.is_on() {
            self.softest = WARY * self.stiffness;
            self.stiffness *= STIFFER[1];
            self.slack = (2.0 * self.slack).min(LOOSE);
        } else {
            self.stiffness =
                if self.last > 0.0 { STIFFER[0] * self.last } else { load / (FIRST_PSEUDO_STEP * full.offset) };
            self.slack = LOOSE;
        }
    }
}
