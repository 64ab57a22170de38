//! The terms of the incremental potential. A physical effect is one file that implements the trait of its scope:
//! [`BodyTerm`] for effects on a pad, [`ObjectTerm`] for effects on the object alone. The solver uses only the sum.

use super::block::{BodyBlock, RigidBlock};
use super::edge::{EdgeReading, EdgeState};
use super::state::{BodyMotion, BodyView, IncrementStart, ObjectIncrement, ObjectView};
pub use super::stencil::Stencil;
use crate::body::Body;
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};
use glam::DVec3;

/// Options of an assembly.
#[derive(Debug, Clone, Copy)]
pub struct Assembly {
    /// Flag: Hessians are projected to their positive semidefinite parts.
    pub project: bool,
    /// Flag: friction limits and planes follow the pressure and the normal; lagged otherwise.
    pub update_friction: bool,
    /// Flag: Hessians are complete, with second derivatives that are harmful far from a solution.
    pub complete_hessian: bool,
    /// Flag: slipping points also have stiffness along their slip, by the secant of their friction energy: steps are
    /// shorter, but descend over a longer range.
    pub secant: bool,
}

impl Assembly {
    /// Options near a solution: friction follows, Hessians are complete.
    pub const COMPLETE: Self = Self { project: false, update_friction: true, complete_hessian: true, secant: false };
    /// [`Assembly::COMPLETE`] with projected Hessians.
    pub const PROJECTED: Self = Self { project: true, ..Self::COMPLETE };
}

/// Copies a term behind its trait object; implemented for every term that is `Clone`.
pub trait TermClone {
    /// Returns a copy with the same history.
    fn boxed_clone(&self) -> Box<dyn BodyTerm>;
}

impl<T: BodyTerm + Clone + 'static> TermClone for T {
    fn boxed_clone(&self) -> Box<dyn BodyTerm> {
        Box::new(self.clone())
    }
}

/// One physical effect on one body: value, gradient, Hessian, and its history between accepted states.
pub trait BodyTerm: TermClone + Send + Sync {
    /// Energy, J; `+inf` where the state is not feasible. Quantities lagged by [`BodyTerm::assemble`] stay fixed.
    fn energy(&self, body: &Body, view: &BodyView) -> f64;
    /// Adds gradient and Hessian to `block`; updates lagged quantities.
    fn assemble(&mut self, body: &Body, view: &BodyView, how: Assembly, block: &mut BodyBlock);
    /// Adds to the gradients of `change` the change of the term's forces along a small `motion` that its (symmetric)
    /// Hessian does not include.
    fn add_nonsymmetric_change(&self, _body: &Body, _view: &BodyView, _motion: &BodyMotion, _change: &mut BodyBlock) {}
    /// Begins an increment: the next solves start from this accepted state.
    fn begin_increment(&mut self, _from: &IncrementStart) {}
    /// Distance by which every point may move before the term must be evaluated again, m.
    fn clearance(&self, _body: &Body, _view: &BodyView) -> f64 {
        f64::INFINITY
    }
    /// Accepts the increment: updates the history.
    fn commit(&mut self, _body: &Body, _view: &BodyView) {}
    /// Rejects the increment: discards all changes since the last commit.
    fn rollback(&mut self) {}
    /// Returns true if the converged state satisfies the conditions of the term beyond equilibrium (no penetration); if
    /// not, the term has stiffened itself and the solve continues.
    fn enforce_constraints(&mut self, _body: &Body, _view: &BodyView) -> bool {
        true
    }
    /// Number of contact edges of the term, open ones included.
    fn edge_count(&self) -> usize {
        0
    }
    /// Readings of the contact edges that are not open, in the order of their numbers, at the state of the last
    /// assembly.
    fn edge_readings(&self, _view: &BodyView) -> Vec<EdgeReading> {
        Vec::new()
    }
    /// Restores the accepted edges that are not open, given by their numbers in ascending order.
    fn set_edges(&mut self, _edges: &[(usize, EdgeState)]) {}
    /// Writes everything that the next increment depends on, except the edges.
    fn save_state(&self, _history: &mut StateWriter) {}
    /// Reads the data of [`BodyTerm::save_state`].
    ///
    /// # Errors
    /// Fails if the history does not match this term.
    fn restore_state(&mut self, _history: &mut StateReader) -> Result<()> {
        Ok(())
    }
}

/// One physical effect on the object alone. Its methods are those of [`BodyTerm`], in the object's pose.
pub trait ObjectTerm: Send + Sync {
    /// Energy, J.
    fn energy(&self, view: &ObjectView) -> f64;
    /// Adds gradient and Hessian to `block`; updates lagged quantities.
    fn assemble(&mut self, view: &ObjectView, how: Assembly, block: &mut RigidBlock);
    /// Adds to `change` the change of the term's forces along a small `motion` that its (symmetric) Hessian does not
    /// include.
    fn add_nonsymmetric_change(&self, _view: &ObjectView, _motion: &ObjectIncrement, _change: &mut RigidBlock) {}
    /// Distance by which every point may move before the term must be evaluated again, m.
    fn clearance(&self, _view: &ObjectView) -> f64 {
        f64::INFINITY
    }
    /// Accepts the increment: updates the history.
    fn commit(&mut self, _view: &ObjectView) {}
    /// Rejects the increment: discards all changes since the last commit.
    fn rollback(&mut self) {}
    /// Returns true if the converged state satisfies the conditions of the term beyond equilibrium.
    fn enforce_constraints(&mut self) -> bool {
        true
    }
    /// Writes everything that the next increment depends on.
    fn save_state(&self, history: &mut StateWriter);
    /// Reads the data of [`ObjectTerm::save_state`].
    ///
    /// # Errors
    /// Fails if the history does not match this term.
    fn restore_state(&mut self, history: &mut StateReader) -> Result<()>;
}

/// Elastic energy of the gel.
#[derive(Debug, Clone, Default)]
pub struct ElasticEnergy;

impl BodyTerm for ElasticEnergy {
    fn energy(&self, body: &Body, view: &BodyView) -> f64 {
        body.energy(view.x)
    }

    fn assemble(&mut self, body: &Body, view: &BodyView, how: Assembly, block: &mut BodyBlock) {
        match block.wants_hessian() {
            true => body.add_stiffness(view.x, how.project, &mut block.gradient, &mut block.values),
            false => body.add_gradient(view.x, &mut block.gradient),
        }
    }
}

/// Dead loads on nodes: potential `-sum f . x`.
#[derive(Debug, Clone)]
pub struct NodalLoads(pub Vec<DVec3>);

impl BodyTerm for NodalLoads {
    fn energy(&self, _: &Body, view: &BodyView) -> f64 {
        -self.0.iter().zip(view.x).map(|(f, x)| f.dot(*x)).sum::<f64>()
    }

    fn assemble(&mut self, _: &Body, _: &BodyView, _: Assembly, block: &mut BodyBlock) {
        for (g, f) in block.gradient.iter_mut().zip(&self.0) {
            *g -= *f;
        }
    }
}
