//! Pseudo-time: springs from the accepted state to the next one, which bound the motion of one step.
//!
//! An object that rolls or slides passes through states that are no equilibria. A step with springs is one of implicit gradient descent
//! (pseudo-transient continuation: Kelley and Keyes 1998): it has a solution near the state before whatever the load does. The stiffness
//! follows from how the steps go: softer after an easy one, stiffer after one that went too far or failed, none once the springs pull no
//! more than the forces are out of balance anyhow.

use super::LOOSE;
use crate::mech::newton::NewtonTolerance;
use crate::mech::newton::proximal::Proximal;
use crate::mech::potential::state::State;
use crate::scales::{PSEUDO_TIME_BEGINS, PSEUDO_TIME_REACH};
use serde::{Deserialize, Serialize};

/// Maximum number of iterations of one step with springs.
const STEP_ITERATIONS: u32 = 25;
/// Stiffness of the springs of the nodes over those of the rigid unknowns.
const NODES: f64 = 0.3;
/// Forces out of balance that a step may leave, over those that drive it; and pull of the springs at rest, over forces that may be out of
/// balance.
const FOLLOWED: f64 = 0.3;
/// Iterations up to which a step was easy, and from which on it was hard.
const EASY: u32 = 8;
const HARD: u32 = 15;
/// Springs after a step that was easy, or not so easy, over those of the step; and after one that went too far, or failed.
const SOFTER: [f64; 2] = [0.25, 0.5];
const STIFFER: [f64; 2] = [2.0, 8.0];
/// Least stiffness of the springs after a step that failed, over that of its own, and the factor by which it falls with every
/// step after it.
const WARY: f64 = 3.0;
const FORGETTING: f64 = 0.7;
/// Pull of the springs over the load above which the load waits for the object.
const WAITS: f64 = 0.02;

/// State of the springs.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct PseudoTime {
    /// Stiffness of the springs of the rigid unknowns, N/m; zero without springs.
    stiffness: f64,
    /// Stiffness below which the next steps do not go, N/m: one that failed is not tried again soon with springs as soft.
    softest: f64,
    /// Stiffness of the last springs, N/m.
    last: f64,
    /// Tolerance of the next step over that of a result.
    slack: f64,
    /// Flag: the springs pull so much that the load waits.
    pub waits: bool,
}

/// What came of a step.
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

    /// The springs of the next step, from `state`.
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

    /// Returns true if the state after a step in which the springs pull with `pull` (N) is one of rest, with forces of up to `floor` (N)
    /// out of balance.
    pub fn rests(&self, pull: f64, floor: f64) -> bool {
        self.slack == 1.0 && pull <= FOLLOWED * floor
    }

    /// Takes note of a step with springs under `load` (N) that was accepted. The load has changed in it if it was `loaded`.
    pub fn accept(&mut self, moved: &PseudoStep, load: f64, floor: f64, full: &NewtonTolerance, loaded: bool) {
        if !self.is_on() {
            return;
        }
        self.last = self.stiffness;
        if self.rests(moved.pull, floor) && loaded {
            *self = Self { last: self.last, ..Self::NONE };
            return;
        }
        let reach = PSEUDO_TIME_REACH * full.offset;
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

    /// Takes note of a step under `load` (N) that failed.
    pub fn refuse(&mut self, load: f64, full: &NewtonTolerance) {
        if self.is_on() {
            self.softest = WARY * self.stiffness;
            self.stiffness *= STIFFER[1];
            self.slack = (2.0 * self.slack).min(LOOSE);
        } else {
            self.stiffness =
                if self.last > 0.0 { STIFFER[0] * self.last } else { load / (PSEUDO_TIME_BEGINS * full.offset) };
            self.slack = LOOSE;
        }
    }
}
