//! Proximal springs to the previous state, with which a pseudo-time step is an implicit step of gradient descent.

use super::arrow::ArrowBlock;
use crate::body::Body;
use crate::body::pattern::Pattern;
use crate::potential::block::{BodyBlock, RigidBlock};
use crate::potential::state::{RigidUnknowns, State};
use glam::{DMat3, DVec3};

/// Springs that pull rigid unknowns and nodes towards `center`.
#[derive(Debug)]
pub struct Proximal {
    /// Previous state.
    pub center: State,
    /// Stiffness of the rigid unknowns, N/m per column.
    pub rigid: f64,
    /// Stiffness of every free node, N/m.
    pub nodes: f64,
}

impl Proximal {
    /// Adds gradient and Hessian of the springs of the rigid unknowns at `state`.
    pub(crate) fn assemble_rigid(&self, rigid: &RigidUnknowns, state: &State, block: &mut RigidBlock) {
        let moved = rigid.difference(state, &self.center);
        block.gradient.iter_mut().zip(moved).for_each(|(g, d)| *g += self.rigid * d);
        if block.wants_hessian {
            (0..rigid.size).for_each(|c| block.hessian[c][c] += self.rigid);
        }
    }

    /// Energy of the springs at `state`, J.
    pub(crate) fn energy(&self, rigid: &RigidUnknowns, bodies: &[ArrowBlock], state: &State) -> f64 {
        let rigid = rigid.difference(state, &self.center).iter().map(|d| d * d).sum::<f64>();
        0.5 * self.rigid * rigid + 0.5 * self.nodes * self.spread(bodies, state)
    }

    /// Force of all springs at `state`, N.
    pub(crate) fn pull(&self, rigid: &RigidUnknowns, bodies: &[ArrowBlock], state: &State) -> f64 {
        let rigid = rigid.distance(state, &self.center);
        (self.rigid * rigid).hypot(self.nodes * self.spread(bodies, state).sqrt())
    }

    /// Adds gradient and Hessian of the springs of body `index` at node positions `x`, m.
    pub(crate) fn assemble(&self, index: usize, body: &Body, x: &[DVec3], block: &mut BodyBlock) {
        let stiffness = DMat3::from_diagonal(DVec3::splat(self.nodes));
        for (i, (x, c)) in x.iter().zip(&self.center.x[index]).enumerate().filter(|(i, _)| !body.fixed[*i]) {
            block.gradient[i] += (*x - *c) * self.nodes;
            if block.wants_hessian() {
                Pattern::add(&mut block.values, body.pattern().slot(i as u32, i as u32), &stiffness);
            }
        }
    }

    /// Sum of the squared displacements of the free nodes, m2.
    fn spread(&self, bodies: &[ArrowBlock], state: &State) -> f64 {
        let of = |i: usize| {
            let nodes = state.x[i].iter().zip(&self.center.x[i]).zip(&bodies[i].body.fixed);
            nodes.filter(|(_, fixed)| !**fixed).map(|((x, c), _)| x.distance_squared(*c)).sum::<f64>()
        };
        (0..bodies.len()).map(of).sum()
    }
}
