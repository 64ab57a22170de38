//! Proximal springs to the previous state, with which a pseudo-time step is an implicit step of gradient descent.

use super::arrow::ArrowBlock;
use crate::body::Body;
use crate::body::pattern::Pattern;
use crate::potential::block::{BodyBlock, RigidBlock};
use crate::potential::state::{RigidUnknowns, State};
use glam::{DMat3, DVec3};

/// Springs that pull rigid unknowns and nodes towards `center`.
#[derive(Debug)]
pub struct ProximalSprings {
    /// Previous state.
    pub center: State,
    /// Stiffness of the rigid unknowns, N/m per column.
    pub rigid_stiffness: f64,
    /// Stiffness of every free node, N/m.
    pub node_stiffness: f64,
}

impl ProximalSprings {
    /// Adds gradient and Hessian of the springs of the rigid unknowns at `state`.
    pub(crate) fn assemble_rigid(&self, rigid: &RigidUnknowns, state: &State, block: &mut RigidBlock) {
        let moved = rigid.difference(state, &self.center);
        block.gradient.iter_mut().zip(moved).for_each(|(g, d)| *g += self.rigid_stiffness * d);
        if block.wants_hessian {
            (0..rigid.size).for_each(|c| block.hessian[c][c] += self.rigid_stiffness);
        }
    }

    /// Energy of the springs at `state`, J.
    pub(crate) fn energy(&self, rigid: &RigidUnknowns, bodies: &[ArrowBlock], state: &State) -> f64 {
        let rigid = rigid.difference(state, &self.center).iter().map(|d| d * d).sum::<f64>();
        0.5 * self.rigid_stiffness * rigid + 0.5 * self.node_stiffness * self.squared_distance(bodies, state)
    }

    /// Force of all springs at `state`, N.
    pub(crate) fn force(&self, rigid: &RigidUnknowns, bodies: &[ArrowBlock], state: &State) -> f64 {
        let rigid = rigid.distance(state, &self.center);
        (self.rigid_stiffness * rigid).hypot(self.node_stiffness * self.squared_distance(bodies, state).sqrt())
    }

    /// Adds gradient and Hessian of the springs of body `index` at node positions `x`, m.
    pub(crate) fn assemble(&self, index: usize, body: &Body, x: &[DVec3], block: &mut BodyBlock) {
        let stiffness = DMat3::from_diagonal(DVec3::splat(self.node_stiffness));
        for (i, (x, c)) in x.iter().zip(&self.center.x[index]).enumerate().filter(|(i, _)| !body.fixed[*i]) {
            block.gradient[i] += (*x - *c) * self.node_stiffness;
            if block.wants_hessian() {
                Pattern::add(&mut block.values, body.pattern().slot(i as u32, i as u32), &stiffness);
            }
        }
    }

    /// Sum of the squared displacements of the free nodes, m2.
    fn squared_distance(&self, bodies: &[ArrowBlock], state: &State) -> f64 {
        let of = |i: usize| {
            let nodes = state.x[i].iter().zip(&self.center.x[i]).zip(&bodies[i].body.fixed);
            nodes.filter(|(_, fixed)| !**fixed).map(|((x, c), _)| x.distance_squared(*c)).sum::<f64>()
        };
        (0..bodies.len()).map(of).sum()
    }
}
