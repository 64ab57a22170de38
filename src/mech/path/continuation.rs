//! Continuation of the load in increments, and the methods that are tried where one fails.
//!
//! An attempt at a level is accepted, or the increment shrinks, or the method changes:
//!
//! | what an attempt ends with | answer |
//! |---|---|
//! | the path bends too far | a smaller increment, by the error (`step_size.rs`) |
//! | no equilibrium | half the increment, three times where there are rigid unknowns, else twelve |
//! | no equilibrium under a push | halfway to the load that found none; within a thousandth of it the object slips, or the grasp ends (`backend/fem/level.rs`) |
//! | none in the smallest increment either | pseudo-time from the accepted state (`pseudo_transient.rs`), over the increment that was refused first |
//! | none in pseudo-time; corrections of condensed pads do not settle | half the increment, condensed pads anew as they are, ten times |
//! | contact outgrows the patch of a condensed pad | condensed anew onto a larger one, the same increment |
//! | condensed pads get no further | whole pads, from the level accepted last (`backend/fem/level.rs`) |
//! | the object left the grasp; no effort is left | the grasp ends |
//! | a time step finds no equilibrium (`backend/fem/dynamics/integrator.rs`) | half the step, down to a 64th of the scene's |
//!
//! [`Methods`] counts how often each was needed.

use super::{Advanced, Load, Path};
use crate::mech::newton::Failure;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::AddAssign;

/// Counts of how often each method of the continuation was used.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Methods {
    /// Accepted increments.
    pub increments: u64,
    /// Increments for which the path bent too far.
    pub bent: u64,
    /// Increments halved because no equilibrium was found.
    pub halved: u64,
    /// Solutions in which friction swung and was frozen.
    pub frozen: u64,
    /// Iterations whose stiffness had to be projected.
    pub projected: u64,
    /// Pseudo-transient continuations.
    pub pseudo_transient: u64,
    /// Pads condensed anew on the way to a level.
    pub condensed_anew: u64,
    /// Grasps that went on with whole pads where condensed ones got no further.
    pub whole: u64,
}

impl Methods {
    /// Counts, each with its name.
    pub fn counts(&self) -> [(&'static str, u64); 8] {
        [
            ("increments", self.increments),
            ("bent too far", self.bent),
            ("halved", self.halved),
            ("with friction frozen", self.frozen),
            ("with projected stiffness", self.projected),
            ("in pseudo-time", self.pseudo_transient),
            ("condensed anew", self.condensed_anew),
            ("gone on whole", self.whole),
        ]
    }
}

impl AddAssign for Methods {
    fn add_assign(&mut self, more: Self) {
        self.increments += more.increments;
        self.bent += more.bent;
        self.halved += more.halved;
        self.frozen += more.frozen;
        self.projected += more.projected;
        self.pseudo_transient += more.pseudo_transient;
        self.condensed_anew += more.condensed_anew;
        self.whole += more.whole;
    }
}

/// Lists the methods that were used, like `57 increments, 3 halved`.
impl fmt::Display for Methods {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let used = self.counts().into_iter().filter(|(_, count)| *count > 0);
        let used: Vec<_> = used.map(|(what, count)| format!("{count} {what}")).collect();
        f.write_str(&used.join(", "))
    }
}

/// Discretisation of the pads: what an attempt takes beyond an equilibrium.
pub trait PadDiscretisation {
    /// Returns true if an attempt may fail after its equilibrium was accepted, and the pads may be discretised anew.
    fn corrects(&self) -> bool {
        false
    }
    /// Begins an attempt at `level`.
    fn predict(&mut self, _path: &mut Path, _level: f64) {}
    /// Corrects the equilibrium found at `level` to that of the whole pads, within the full tolerance if it is a `result`.
    ///
    /// # Errors
    /// Fails if that equilibrium is not reached; the [`Failure`] says why.
    fn correct(&mut self, _path: &mut Path, _level: f64, _result: bool, _done: &mut Advanced) -> Result<(), Failure> {
        Ok(())
    }
    /// Takes note that the attempt ended in the state of `path` with `failure`.
    fn fail(&mut self, _path: &Path, _failure: Failure) {}
    /// Takes note that `path` is back at the accepted state.
    fn restore(&mut self) {}
    /// Discretises the pads anew at the state of `path`.
    ///
    /// # Errors
    /// Fails with [`Failure::Singular`] if the pads cannot be discretised there.
    fn renew(&mut self, _path: &mut Path) -> Result<(), Failure> {
        Ok(())
    }
}

/// Pads whose nodes are all unknowns.
pub struct WholePads;

impl PadDiscretisation for WholePads {}

/// Number of halvings of an increment before another method: for a path with nothing but bodies, and for one whose object can
/// move.
const HALVINGS: [u32; 2] = [12, 3];
/// Distance from a push that finds no equilibrium, over the push wanted, at which none exists. An object that slips is told
/// from one that only rolls on by increments this small: at a hundredth, an ellipsoid counts as lost at nine tenths of what it bears.
const SLIP_ERROR: f64 = 0.001;
/// Maximum number of changes of the method on the way to one level.
const CHANGES: u32 = 10;
/// Largest increment of a force over the force reached.
const GROWTH: f64 = 3.0;

impl Path {
    /// Raises the load to `target` in as many increments as convergence and error ask for; at `target` already, finds the equilibrium
    /// there once more. Halts at the end of a stage of pseudo-time, with the state there.
    ///
    /// # Errors
    /// The last [`Failure`] when no method is left. State, history and level are then those of the last accepted increment.
    pub fn advance(&mut self, load: Load, target: f64, pads: &mut dyn PadDiscretisation) -> Result<Advanced, Failure> {
        // Under a dead push nothing stops an object once it goes.
        let can_roll = self.newton.rigid.size > 0 && load != Load::Push;
        let (mut done, mut halvings, mut changes) = (Advanced::default(), 0, 0);
        // Increment that was refused first since the last one that was accepted.
        let mut refused = None;
        // Push that found no equilibrium, nearest to the one accepted.
        let mut beyond = None;
        loop {
            let rest = target - self.level;
            let gap = beyond.map_or(f64::INFINITY, |push: f64| (push - self.level).abs());
            let smallest = SLIP_ERROR * target.abs();
            let near = gap <= smallest;
            let longest = self.longest(load).min(0.5 * gap);
            let planned = if near { gap.copysign(rest) } else { self.step.next(rest).clamp(-longest, longest) };
            // An object with a largest drift is followed at once: smaller increments would only find out later that it slides.
            let tried = match load {
                _ if self.largest_drift.is_some() || planned == 0.0 => true,
                Load::Push => planned.abs() <= smallest,
                Load::Force | Load::Travel => halvings >= HALVINGS[usize::from(can_roll)],
            };
            let last_resort = tried || self.exhausted();
            // Pseudo-time follows the whole increment: next to nothing would drive it on over a tiny one. A push has none, and what was
            // refused would only be refused again.
            let whole = refused.filter(|_| last_resort && load != Load::Push);
            let size = whole.map_or(planned, |first: f64| first.clamp(-rest.abs(), rest.abs()));
            let next = if size.abs() >= rest.abs() { target } else { self.level + size };
            self.at_once |= last_resort && can_roll && refused.is_some();
            let cost = done.iterations;
            let failure = match self.attempt(load, next, next == target, last_resort && can_roll, pads, &mut done) {
                Ok(_) if done.halted => return Ok(done),
                Ok(error) => {
                    self.methods.increments += 1;
                    if size != 0.0 {
                        let shortest = self.control.map_or(0.0, |control| self.shortest(control.first));
                        self.step.accept(size, done.iterations - cost, error, shortest);
                    }
                    (halvings, refused) = (0, None);
                    beyond = beyond.filter(|_| !near);
                    if next == target {
                        return Ok(done);
                    }
                    continue;
                }
                Err(failure) => failure,
            };
            match failure {
                Failure::Bent(error) => {
                    self.methods.bent += 1;
                    self.step.refuse(size, Some(error));
                }
                Failure::Astray => return Err(failure),
                _ if failure.is_out_of_effort() => return Err(failure),
                Failure::Iterations(_)
                | Failure::LineSearch(_)
                | Failure::Singular
                | Failure::Lost
                | Failure::Unsettled
                    if !last_resort =>
                {
                    (halvings, self.methods.halved) = (halvings + 1, self.methods.halved + 1);
                    refused = refused.or(Some(size));
                    beyond = (load == Load::Push).then_some(next);
                    self.step.refuse(size, None);
                }
                Failure::Iterations(_)
                | Failure::LineSearch(_)
                | Failure::Singular
                | Failure::Lost
                | Failure::Unsettled
                    if load == Load::Push =>
                {
                    return Err(failure);
                }
                // Whole pads at the same load would only fail in the same way again.
                _ if size == 0.0 && !pads.corrects() => return Err(failure),
                _ if changes >= CHANGES || self.exhausted() => return Err(failure),
                _ => {
                    pads.renew(self)?;
                    (halvings, changes) = (0, changes + 1);
                    self.methods.condensed_anew += u64::from(pads.corrects());
                    (refused, beyond) = (None, None);
                    if failure != Failure::Outside && size != 0.0 {
                        self.step.refuse(size, None);
                    }
                }
            }
        }
    }

    /// Makes one attempt at level `next`, which is a `result` or only on the way to one. Returns the error of the increment
    /// over the error allowed.
    fn attempt(
        &mut self,
        load: Load,
        next: f64,
        result: bool,
        pseudo_time: bool,
        pads: &mut dyn PadDiscretisation,
        done: &mut Advanced,
    ) -> Result<f64, Failure> {
        let saved = pads.corrects().then(|| self.checkpoint());
        pads.predict(self, next);
        self.apply(load, next);
        let before = (self.state.clone(), self.level);
        let start = self.start(load, next);
        let to = (next != self.level).then_some(next);
        let found = self.equilibrate(start, to, pseudo_time, done);
        let corrected = match found {
            Ok(error) if !done.halted => pads.correct(self, next, result, done).map(|()| error),
            found => found,
        };
        match corrected {
            Ok(error) if done.halted => Ok(error),
            Ok(error) => {
                if to.is_some() {
                    (self.history, self.level) = (Some(before), next);
                }
                Ok(error)
            }
            Err(failure) => {
                pads.fail(self, failure);
                self.apply(load, self.level);
                if let Some(saved) = saved {
                    self.restore(saved);
                    pads.restore();
                }
                Err(failure)
            }
        }
    }

    /// Longest increment from the accepted state.
    fn longest(&self, load: Load) -> f64 {
        // From a small load on, contact spreads fast: a load many times as large is not near.
        let near = if load == Load::Force && self.level > 0.0 { GROWTH * self.level } else { f64::INFINITY };
        match self.control {
            // Nothing is known of the path yet.
            Some(control) if self.history.is_none() => near.min(control.first.max(self.level)),
            _ => near,
        }
    }
}
