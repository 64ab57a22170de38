//! Pseudo-time: follows an object that rolls or slides, at fixed load, to where it rests.

use super::increment::{Advanced, LOOSE, Path};
use super::newton::{Converged, Failure, Tolerance};
use super::state::State;

/// Motion of the border that the first pseudo-time step allows under the full load, m.
const STRIDE: f64 = 2e-4;
/// Motion of the border in one pseudo-time step that is far enough, m.
const REACH: f64 = 1e-3;
/// Pseudo-time steps in a row with a finger that touches nothing after which the object counts as gone.
const APART: u32 = 5;
/// Most iterations of one pseudo-time step, and of one walk.
const WALKING: u32 = 25;
const PATIENCE: u32 = 500;

impl Path {
    /// Pseudo-time steps at fixed load from the accepted state, each an equilibrium with a spring to the one before, until
    /// an equilibrium without the spring is near: follows an object that rolls or slides to where it comes to rest.
    pub(super) fn walk(&mut self, done: &mut Advanced) -> Result<State, Failure> {
        let load = self.newton.force.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        let full = self.tolerance;
        let floor = full.force.max(full.relative * load);
        let loose = Tolerance {
            relative: LOOSE * full.relative,
            force: LOOSE * floor,
            iterations: full.iterations.min(WALKING),
            ..full
        };
        let mut stiffness = load / STRIDE;
        let mut state = self.state.clone();
        let (mut failures, mut apart, mut near, mut spent) = (0, 0, false, 0);
        while spent < PATIENCE {
            self.newton.proximal = Some((state.clone(), stiffness));
            let mut next = state.clone();
            match self.newton.solve(&mut next, if near { &full } else { &loose }) {
                Ok(converged) => {
                    self.newton.commit(&next);
                    spent += converged.iterations;
                    done.iterations += converged.iterations;
                    let way = |from: &State| self.newton.border.distance(&next, from);
                    let (moved, gone) = (way(&state), self.leash.is_some_and(|most| way(&self.state) > most));
                    state = next;
                    // A spring that pulls less than the forces are out of balance anyhow changes nothing.
                    if near && stiffness * moved <= floor {
                        done.accept(Converged { iterations: 0, ..converged });
                        return Ok(state);
                    }
                    near = stiffness * moved <= LOOSE * floor;
                    if gone {
                        return Err(Failure::Astray);
                    }
                    apart = if self.newton.untouched() { apart + 1 } else { 0 };
                    if apart >= APART {
                        return Err(Failure::Lost);
                    }
                    if converged.iterations < 15 && moved < 0.5 * REACH {
                        stiffness *= if converged.iterations < 8 { 0.25 } else { 0.5 };
                    } else if moved > REACH {
                        stiffness *= 2.0;
                    }
                }
                Err(Failure::Lost) => return Err(Failure::Lost),
                Err(failure) => {
                    self.newton.rollback();
                    spent += loose.iterations;
                    done.iterations += loose.iterations;
                    failures += 1;
                    near = false;
                    stiffness *= 8.0;
                    if failures > 8 {
                        return Err(failure);
                    }
                }
            }
        }
        Err(Failure::Unsettled)
    }
}
