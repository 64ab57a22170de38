//! Pseudo-time: follows an object that rolls or slides, at fixed load, to where it rests.

use super::{Advanced, LOOSE, Path};
use crate::mech::newton::proximal::Proximal;
use crate::mech::newton::{Converged, Failure, NewtonTolerance};
use crate::mech::potential::state::State;
use crate::scales::{GONE, PSEUDO_TIME_BEGINS, PSEUDO_TIME_REACH};

/// Maximum number of iterations of one pseudo-time step, of iterations of one continuation, and of steps of one continuation
/// that fail.
const STEP_ITERATIONS: u32 = 25;
const PATIENCE: u32 = 2000;
const FAILURES: u32 = 20;
/// Stiffness of the springs of the nodes over those of the rigid unknowns.
const NODES: f64 = 0.3;
/// Forces out of balance that a step may leave, over those that drive it.
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

impl Path {
    /// Pseudo-time steps at fixed load from the accepted state, each an equilibrium with a spring to the one before, until
    /// an equilibrium without the spring is near: follows an object that rolls or slides to where it comes to rest, or to the
    /// end of a stage, as `done` then says.
    pub(crate) fn pseudo_transient(&mut self, done: &mut Advanced) -> Result<State, Failure> {
        let load = self.newton.force.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let full = self.tolerance;
        let floor = full.force.max(full.relative * load);
        let [begins, reach, gone] = [PSEUDO_TIME_BEGINS, PSEUDO_TIME_REACH, GONE].map(|offsets| offsets * full.offset);
        let mut stiffness = load / begins;
        let mut state = self.state.clone();
        // A step that failed is not tried again soon with a spring as soft.
        let mut softest = 0.0_f64;
        // How many times as far out of balance a step may be as the result.
        let mut slack = LOOSE;
        let (mut failures, mut apart, mut spent) = (0, 0.0, 0);
        while spent < PATIENCE {
            let springs = Proximal { center: state.clone(), rigid: stiffness, nodes: NODES * stiffness };
            self.newton.proximal = Some(springs);
            let tolerance = NewtonTolerance {
                relative: slack * full.relative,
                force: slack * full.force,
                iterations: full.iterations.min(STEP_ITERATIONS),
                passing: slack > 1.0,
                ..full
            };
            match self.newton.solve(&state, state.clone(), &tolerance) {
                Ok((next, converged)) => {
                    self.newton.commit(&next);
                    spent += converged.iterations;
                    done.iterations += converged.iterations;
                    let way = |from: &State| self.newton.rigid.distance(&next, from);
                    let (moved, total) = (way(&state), way(&self.state));
                    let beyond = |most: Option<f64>| most.is_some_and(|most| total > most);
                    let pull = self.newton.proximal.as_ref().map_or(0.0, |springs| springs.pull(&self.newton, &next));
                    state = next;
                    // A spring that pulls less than the forces are out of balance anyhow changes nothing.
                    if slack == 1.0 && pull <= floor {
                        done.accept(Converged { iterations: 0, ..converged });
                        return Ok(state);
                    }
                    slack = (FOLLOWED * pull / floor).clamp(1.0, LOOSE);
                    if beyond(self.largest_drift) {
                        return Err(Failure::Astray);
                    }
                    if beyond(self.stage) {
                        done.halted = true;
                        return Ok(state);
                    }
                    apart = if self.newton.untouched() { apart + moved } else { 0.0 };
                    if apart >= gone {
                        return Err(Failure::Lost);
                    }
                    softest *= FORGETTING;
                    if converged.iterations < HARD && moved < 0.5 * reach {
                        let softer = SOFTER[usize::from(converged.iterations >= EASY)];
                        stiffness = (stiffness * softer).max(softest.min(stiffness));
                    } else if moved > reach {
                        stiffness *= STIFFER[0];
                    }
                }
                Err(failure) if failure == Failure::Lost || failure.is_out_of_effort() => return Err(failure),
                Err(failure) => {
                    self.newton.rollback();
                    spent += tolerance.iterations;
                    done.iterations += tolerance.iterations;
                    failures += 1;
                    softest = WARY * stiffness;
                    slack = (2.0 * slack).min(LOOSE);
                    stiffness *= STIFFER[1];
                    if failures > FAILURES {
                        return Err(failure);
                    }
                }
            }
        }
        Err(Failure::Unsettled)
    }
}
