//! Quantities of the full pads from the solver of a grasp, whether the pads are condensed or not; start of the
//! condensation and fallback to the full model.

use super::solver::{GraspSolver, full_pad_terms, gel_weight_per_node};
use glam::DVec3;
use mech::body::Body;
use mech::potential::inversion_barrier::needs_inversion_barrier;
use mech::potential::term::BodyTerm;
use model::Model;
use rayon::prelude::*;
use std::sync::Arc;

impl GraspSolver {
    /// Condenses the pads in the state of first contact, if the settings select condensed pads; otherwise does nothing.
    ///
    /// # Errors
    /// Fails with the reason if the stiffness of a pad cannot be factorised.
    pub(crate) fn condense(&mut self, model: &Model) -> std::result::Result<(), String> {
        let begun = self.condensed.as_mut().map_or(Ok(()), |pads| pads.condense_at_contact(&mut self.path, model));
        begun.map_err(|f| self.failure_message(model, "condensing the pads", f))
    }

    /// Returns false if an element of a condensed pad is close to inversion: det F is below 0.02 at a node or at the
    /// centre. Condensed pads have no barrier against inversion. Always returns true for full pads.
    pub(crate) fn has_no_near_inversion(&self) -> bool {
        let pads = self.condensed.as_ref();
        pads.is_none_or(|pads| {
            !self.path.state.x.par_iter().enumerate().any(|(i, x)| needs_inversion_barrier(pads.pad(i).body(), x))
        })
    }

    /// Replaces the condensed pads by the full pads in the current state, for the rest of the grasp.
    ///
    /// # Errors
    /// Fails if the symbolic factorisation of a full pad fails.
    pub(crate) fn fall_back_to_full_pads(&mut self, model: &Model) -> std::result::Result<(), String> {
        self.condensed = None;
        self.path.halve_spent_iterations();
        for (i, finger) in model.fingers.iter().enumerate() {
            self.path.newton.replace_body(i, finger.body.clone()).map_err(|e| e.to_string())?;
            self.path.newton.gel[i] = full_pad_terms(gel_weight_per_node(model, i, self.progress.start));
        }
        Ok(())
    }

    /// Returns the full (not condensed) pad of finger `i` (0 left, 1 right).
    pub fn body(&self, i: usize) -> &Arc<Body> {
        self.condensed.as_ref().map_or_else(|| self.path.newton.body(i), |pads| pads.pad(i).body())
    }

    /// Returns the value of the incremental potential in the accepted state, J, with the strain energy of the full
    /// pads.
    pub fn energy(&self) -> f64 {
        let (newton, state) = (&self.path.newton, &self.path.state);
        let Some(pads) = &self.condensed else { return newton.energy(state) };
        let full: Vec<f64> = state.x.par_iter().enumerate().map(|(i, x)| pads.pad(i).energy(x)).collect();
        let condensed = state
            .x
            .iter()
            .enumerate()
            .map(|(i, _)| pads.pad(i).term().energy(newton.body(i), &state.view(i, &newton.rigid)));
        newton.energy(state) + full.iter().sum::<f64>() - condensed.sum::<f64>()
    }

    /// Returns the force that finger `i` exerts on its pad, N, hand frame: the sum of the reactions at the bonded nodes
    /// in the equilibrium found last.
    pub fn mount_force(&self, i: usize) -> DVec3 {
        let bonded = |forces: &[DVec3]| -> DVec3 {
            forces.iter().zip(&self.body(i).fixed).filter(|(_, fixed)| **fixed).map(|(g, _)| *g).sum()
        };
        // The gradient of the condensed system has only the contact forces on bonded nodes.
        let elastic = self.condensed.as_ref().map_or(DVec3::ZERO, |pads| bonded(pads.pad(i).gradient()));
        bonded(self.path.newton.gradient(i)) + elastic
    }

    /// Returns the weight of the gel of finger `i` as a force, N, hand frame; zero without gravity.
    pub fn gel_weight(&self, model: &Model, i: usize) -> DVec3 {
        let finger = &model.fingers[i];
        let volume = || finger.body.nodal_volume().iter().sum::<f64>();
        model.gravity.map_or(DVec3::ZERO, |g| self.progress.start.rotation * g * (volume() * finger.gel_density))
    }
}
