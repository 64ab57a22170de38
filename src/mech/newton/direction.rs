//! Newton direction: the symmetric system is solved by its factorisation, the nonsymmetric part by iteration.
//!
//! The Hessian of frozen friction is symmetric, but the friction limit grows with the pressure: where a point slips, a motion
//! against the object also changes the force along it. That part has no potential. It is put on the right-hand side a few
//! times, which costs a triangular solve each instead of a nonsymmetric factorisation, and restores the fast convergence of
//! Newton's method where points slip.

use super::Newton;
use super::arrow;
use crate::mech::potential::state::{MAX_RIGID, NewtonStep, State};
use rayon::prelude::*;

/// Maximum number of corrections of one direction.
const CORRECTIONS: usize = 4;
/// Largest ratio of two successive corrections; above it the plain direction is taken.
const CONTRACTION: f64 = 0.7;
/// Size of a correction over the direction below which another solve is not worthwhile.
const ENOUGH: f64 = 0.03;

impl Newton {
    /// Computes the step from the assembled and factorised state `now`, and the gradient of the rigid unknowns that it answers.
    /// No step in the rigid unknowns is longer than `cap` (m) along an axis of its own. `anew`: the factorisation is new.
    /// `follow`: friction limits follow.
    pub(crate) fn direction(
        &mut self,
        now: &State,
        cap: f64,
        anew: bool,
        follow: bool,
    ) -> (NewtonStep, [f64; MAX_RIGID]) {
        self.blocks.par_iter_mut().for_each(|b| {
            b.extra.clear(false);
            b.solve(anew);
        });
        let gradient = self.rigid_gradient();
        let columns = [self.unknowns(), self.rigid.size];
        let plain = arrow::step(&self.blocks, &self.object_block, &gradient, columns, cap);
        if !follow {
            return (plain, gradient);
        }
        let (mut step, mut last) = (plain.clone(), plain.norm());
        for _ in 0..CORRECTIONS {
            if !self.couple(now, &step) {
                break;
            }
            self.blocks.par_iter_mut().for_each(|b| b.solve(false));
            let mut g = gradient;
            let extras = self.blocks.iter().map(|b| &b.extra.rigid).chain([&self.object_extra]);
            extras.for_each(|extra| g.iter_mut().zip(extra.gradient).for_each(|(g, e)| *g += e));
            let next = arrow::step(&self.blocks, &self.object_block, &g, columns, cap);
            let change = next.distance(&step);
            if change.total_cmp(&(CONTRACTION * last)).is_gt() {
                return (plain, gradient);
            }
            (step, last) = (next, change);
            if change <= ENOUGH * step.norm() {
                break;
            }
        }
        // What has no potential may lead uphill in the one that the line search goes by.
        if self.slope(&step, &gradient) < 0.0 { (step, gradient) } else { (plain, gradient) }
    }

    /// Collects the change of the forces along `step` beyond what the Hessian says; returns false if there is none.
    fn couple(&mut self, now: &State, step: &NewtonStep) -> bool {
        let (rigid, terms) = (&self.rigid, &self.terms);
        self.blocks.par_iter_mut().enumerate().for_each(|(i, b)| {
            b.extra.clear(false);
            let view = now.view(i, rigid);
            terms[i].iter().for_each(|t| t.couple(&b.body, &view, &step.motion(i, &view), &mut b.extra));
        });
        self.object_extra.clear(false);
        self.object.couple(now, rigid, step, &mut self.object_extra);
        self.object_extra.activity > 0.0 || self.blocks.iter().any(|b| b.extra.rigid.activity > 0.0)
    }
}
