//! Newton direction: the symmetric system is solved by its factorisation, the nonsymmetric part by a Krylov method.
//!
//! The Hessian at lagged friction is symmetric, but the friction limit grows with the pressure: where a point slips, a
//! normal motion also changes the tangential force. That part has no potential, and its rank is small. The symmetric
//! system preconditions a generalised conjugate residual method (Eisenstat, Elman and Schultz 1983), whose vectors cost
//! one triangular solve each instead of a nonsymmetric factorisation. It restores the fast convergence of Newton's
//! method where points slip.

use super::Newton;
use super::arrow::RigidSystem;
use crate::potential::state::{MAX_RIGID, NewtonStep, State};
use rayon::prelude::*;

/// Maximum number of Krylov vectors of one direction.
const KRYLOV_VECTORS: usize = 8;
/// Residual of the direction over the direction below which no further vector is added.
const KRYLOV_TOLERANCE: f64 = 0.01;

impl Newton {
    /// Computes the step of the assembled and factorised system at lagged friction, and the gradient of the rigid
    /// unknowns. The step in the rigid unknowns is at most `cap` (m) long.
    pub(crate) fn direction(&mut self, cap: f64) -> (NewtonStep, [f64; MAX_RIGID]) {
        self.blocks.par_iter_mut().for_each(|b| {
            b.extra.clear(false);
            b.solve(true);
        });
        let gradient = self.rigid_gradient();
        self.rigid_system =
            RigidSystem::new(&self.blocks, &self.object_block, &gradient, [self.unknowns(), self.rigid.size], cap);
        (self.rigid_system.step(&self.blocks, &gradient), gradient)
    }

    /// Corrects the direction `plain` at `now`, computed at lagged friction under `gradient`, for limits that follow
    /// the pressure. The result is at most `cap` (m) long in the rigid unknowns.
    pub(crate) fn correct_direction(
        &mut self,
        now: &State,
        plain: &NewtonStep,
        gradient: &[f64; MAX_RIGID],
        cap: f64,
    ) -> NewtonStep {
        let mut step = plain.clone();
        let Some(mut rest) = self.response(now, plain, gradient, plain) else { return step };
        let mut vectors: Vec<[NewtonStep; 2]> = Vec::new();
        while vectors.len() < KRYLOV_VECTORS && rest.norm() > KRYLOV_TOLERANCE * step.norm() {
            let mut along = rest.clone();
            let Some(response) = self.response(now, &along, gradient, plain) else { break };
            let mut image = along.clone();
            image.add(&response, -1.0);
            for [direction, unit] in &vectors {
                let part = image.dot(unit);
                image.add(unit, -part);
                along.add(direction, -part);
            }
            let size = image.norm();
            if !size.is_finite() || size <= f64::EPSILON * along.norm() {
                break;
            }
            image.scale(1.0 / size);
            along.scale(1.0 / size);
            let part = rest.dot(&image);
            step.add(&along, part);
            rest.add(&image, -part);
            vectors.push([along, image]);
        }
        let length = step.rigid_norm();
        if length > cap {
            step.scale(cap / length);
        }
        step
    }

    /// Response of the symmetric system to the change of friction forces along `step` that the Hessian does not
    /// include; None if there is no such change.
    fn response(
        &mut self,
        now: &State,
        step: &NewtonStep,
        gradient: &[f64; MAX_RIGID],
        plain: &NewtonStep,
    ) -> Option<NewtonStep> {
        if !self.nonsymmetric_change(now, step) {
            return None;
        }
        self.blocks.par_iter_mut().for_each(|b| b.solve(false));
        let mut g = *gradient;
        let extras = self.blocks.iter().map(|b| &b.extra.rigid).chain([&self.object_extra]);
        extras.for_each(|extra| g.iter_mut().zip(extra.gradient).for_each(|(g, e)| *g += e));
        let mut response = self.rigid_system.step(&self.blocks, &g);
        response.add(plain, -1.0);
        Some(response)
    }

    /// Collects the change of the forces along `step` that the Hessian does not include; returns false if there is
    /// none.
    fn nonsymmetric_change(&mut self, now: &State, step: &NewtonStep) -> bool {
        let (rigid, terms) = (&self.rigid, &self.terms);
        self.blocks.par_iter_mut().enumerate().for_each(|(i, b)| {
            b.extra.clear(false);
            let view = now.view(i, rigid);
            terms[i]
                .iter()
                .for_each(|t| t.add_nonsymmetric_change(&b.body, &view, &step.motion(i, &view), &mut b.extra));
        });
        self.object_extra.clear(false);
        self.object.add_nonsymmetric_change(now, rigid, step, &mut self.object_extra);
        self.object_extra.force_scale > 0.0 || self.blocks.iter().any(|b| b.extra.rigid.force_scale > 0.0)
    }
}
