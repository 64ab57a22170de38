//! Springs to the previous state: they make a pseudo-time step an implicit step of gradient descent.

use super::Newton;
use crate::mech::body::Body;
use crate::mech::body::pattern::Pattern;
use crate::mech::potential::state::{MAX_RIGID, State};
use crate::mech::potential::term::BodyBlock;
use glam::{DMat3, DVec3};

/// Pulls rigid unknowns and nodes towards `center`.
#[derive(Debug)]
pub struct Proximal {
    /// The previous state.
    pub center: State,
    /// Stiffness of the rigid unknowns, N/m per column.
    pub rigid: f64,
    /// Stiffness of every free node, N/m.
    pub nodes: f64,
}

impl Proximal {
    /// Force of the springs on the rigid unknowns at `state`, N.
    pub(crate) fn rigid_gradient(&self, newton: &Newton, state: &State) -> [f64; MAX_RIGID] {
        newton.rigid.difference(state, &self.center).map(|d| self.rigid * d)
    }

    /// Energy of the springs at `state`, J.
    pub(crate) fn energy(&self, newton: &Newton, state: &State) -> f64 {
        let rigid = newton.rigid.difference(state, &self.center).iter().map(|d| d * d).sum::<f64>();
        0.5 * self.rigid * rigid + 0.5 * self.nodes * self.spread(newton, state)
    }

    /// Force that all springs pull with at `state`, N.
    pub(crate) fn pull(&self, newton: &Newton, state: &State) -> f64 {
        let rigid = newton.rigid.distance(state, &self.center);
        (self.rigid * rigid).hypot(self.nodes * self.spread(newton, state).sqrt())
    }

    /// Adds gradient and Hessian of the springs of body `index` at node positions `x`, m.
    pub(crate) fn assemble(&self, index: usize, body: &Body, x: &[DVec3], block: &mut BodyBlock) {
        let stiffness = DMat3::from_diagonal(DVec3::splat(self.nodes));
        for (i, (x, c)) in x.iter().zip(&self.center.x[index]).enumerate().filter(|(i, _)| !body.fixed[*i]) {
            block.gradient[i] += (*x - *c) * self.nodes;
            if block.hessian {
                Pattern::add(&mut block.values, body.pattern().slot(i as u32, i as u32), &stiffness);
            }
        }
    }

    /// Sum of the squared distances of the free nodes, m2.
    fn spread(&self, newton: &Newton, state: &State) -> f64 {
        let of = |i: usize| {
            let nodes = state.x[i].iter().zip(&self.center.x[i]).zip(&newton.body(i).fixed);
            nodes.filter(|(_, fixed)| !**fixed).map(|((x, c), _)| x.distance_squared(*c)).sum::<f64>()
        };
        (0..newton.bodies()).map(of).sum()
    }
}
