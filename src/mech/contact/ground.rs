//! Contact and friction of a free object's vertices with a fixed plane, as a term of the potential.

use super::edge::EdgeState;
use super::law::ContactLaw;
use super::pair::{friction_pair, slip, vertex_pair};
use super::pool::EdgePool;
use crate::potential::block::{Pair, RigidBlock};
use crate::potential::state::{ObjectIncrement, ObjectView};
use crate::potential::term::{Assembly, ObjectTerm};
use crate::potential::time_step::TimeStep;
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};
use geometry::{Pose, Wrench};
use glam::{DMat3, DVec3};
use std::iter;
use std::sync::Arc;

/// Contact of the object with the half-space `normal . x <= height` of the world. Edges are per vertex and hold forces
/// in N where those of pads hold pressures in Pa; the sticking point is in world axes.
#[derive(Debug, Clone)]
pub struct GroundContact {
    /// One edge per vertex.
    pool: EdgePool,
    vertices: Arc<[DVec3]>,
    normal: DVec3,
    height: f64,
    hand: Pose,
    /// World position of each vertex at the last accepted state, m. A vertex that makes contact within a step gets its
    /// sticking point there, so that friction acts on all of its sliding in the step.
    last: Vec<DVec3>,
}

impl GroundContact {
    /// Creates the term with all edges open. `vertices` are points of the object (object frame, m), `law` is per vertex
    /// (stiffness in N/m).
    pub fn new(
        vertices: Arc<[DVec3]>,
        law: ContactLaw,
        normal: DVec3,
        height: f64,
        hand: Pose,
        view: &ObjectView,
    ) -> Self {
        // Limits are forces, not pressures: none counts as negligible.
        let mut pool = EdgePool::new(law, vertices.len());
        pool.negligible = 0.0;
        let last = vertices.iter().map(|v| hand.transform(view.position + view.rotation * *v)).collect();
        Self { pool, vertices, normal, height, hand, last }
    }

    /// Begins a time step.
    pub fn begin_step(&mut self, step: &TimeStep) {
        self.hand = step.hand;
    }

    /// Edges of the vertices near the ground, with the indices of the vertices.
    pub fn edges(&self) -> impl Iterator<Item = (usize, &EdgeState)> {
        self.pool.near()
    }

    /// Force of the ground on the object, and its torque about `center` (hand frame, m), hand axes.
    pub fn wrench(&self, view: &ObjectView, center: DVec3) -> Wrench {
        let mut sum = Wrench::ZERO;
        for (i, v) in self.vertices.iter().enumerate() {
            let e = self.pool.edge(i);
            if e.pressure <= 0.0 {
                continue;
            }
            // The edge holds the force on the ground.
            let force = -(e.normal * e.pressure + e.traction);
            sum.force += force;
            sum.torque += (view.position + view.rotation * *v - center).cross(force);
        }
        sum
    }

    /// Smallest gap of the last assembly, m.
    pub fn min_gap(&self) -> f64 {
        self.pool.min_gap()
    }

    fn gap(&self, world: DVec3) -> f64 {
        self.normal.dot(world) - self.height
    }

    /// Updates gap, force and friction of edge `i`; returns the lag of its friction, N.
    fn update(&mut self, i: usize, view: &ObjectView, update_friction: bool) -> f64 {
        let arm = view.rotation * self.vertices[i];
        let gap = self.gap(self.hand.transform(view.position + arm));
        let (law, last) = (self.pool.law, self.last[i]);
        // The outward normal of the object is the inward one of the ground.
        let normal = -(self.hand.rotation.conjugate() * self.normal);
        let Some(lag) = self.pool.set_pressure(i, &law, update_friction, iter::once((gap, normal, 1.0))) else {
            return 0.0;
        };
        if self.pool.made_contact(i) {
            let clear = self.gap(last);
            self.pool.record_contact(i, &law, last, || clear);
        }
        let anchor = self.pool.edge(i).anchor.unwrap_or(last);
        let behind = self.pool.update_traction(
            i,
            &law,
            update_friction,
            self.hand.inverse_transform(anchor) - view.position - arm,
        );
        lag.hypot(behind)
    }
}

impl ObjectTerm for GroundContact {
    fn energy(&self, view: &ObjectView) -> f64 {
        let mut energy = 0.0;
        for (i, v) in self.vertices.iter().enumerate() {
            let e = self.pool.edge(i);
            let point = view.position + view.rotation * *v;
            energy += self.pool.law.normal_energy(self.gap(self.hand.transform(point)), e.scale);
            if let Some(anchor) = e.sticking_point() {
                energy += e.friction_energy(&self.pool.law, slip(self.hand.inverse_transform(anchor) - point, e.plane));
            }
        }
        energy
    }

    fn assemble(&mut self, view: &ObjectView, how: Assembly, block: &mut RigidBlock) {
        for i in 0..self.vertices.len() {
            block.lag += self.update(i, view, how.update_friction).powi(2);
            let e = *self.pool.edge(i);
            let arm = view.rotation * self.vertices[i];
            if e.pressure > 0.0 {
                block.add_object_pair(view, &vertex_pair(&self.pool.law, &e, 1.0, arm, &DMat3::ZERO, how.project));
            }
            if let Some(anchor) = e.sticking_point() {
                let s = self.hand.inverse_transform(anchor) - view.position - arm;
                block.add_object_pair(view, &friction_pair(&self.pool.law, &e, 1.0, s, arm, how));
            }
        }
    }

    fn clearance(&self, view: &ObjectView) -> f64 {
        let gap = |v: &DVec3| self.gap(self.hand.transform(view.position + view.rotation * *v));
        self.vertices.iter().map(gap).fold(f64::INFINITY, f64::min) - 0.5 * self.pool.law.offset
    }

    fn add_nonsymmetric_change(&self, view: &ObjectView, motion: &ObjectIncrement, change: &mut RigidBlock) {
        for (i, v) in self.vertices.iter().enumerate().filter(|(i, _)| self.pool.edge(*i).sticking_point().is_some()) {
            let r = view.rotation * *v;
            let away = -motion.position - motion.rotation.cross(r);
            if let Some(drag) = self.pool.nonsymmetric_traction(i, &self.pool.law, away) {
                change.add_object_pair(view, &Pair::force(-drag, r));
            }
        }
    }

    fn commit(&mut self, view: &ObjectView) {
        for (last, v) in self.last.iter_mut().zip(self.vertices.iter()) {
            *last = self.hand.transform(view.position + view.rotation * *v);
        }
        let (last, hand, tangential) = (&self.last, &self.hand, self.pool.law.tangential);
        self.pool.commit(|i, e| last[i] - hand.rotation * e.traction * (1.0 / tangential));
    }

    fn rollback(&mut self) {
        self.pool.rollback();
    }

    fn enforce_constraints(&mut self) -> bool {
        let least = self.pool.law.smallest_gap();
        self.pool.stiffen_penetrating(|_| least)
    }

    fn save_state(&self, history: &mut StateWriter) {
        self.pool.save_state(history);
        history.write(&self.last);
    }

    fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        self.pool.restore_state(history)?;
        history.read_into(&mut self.last)
    }
}
