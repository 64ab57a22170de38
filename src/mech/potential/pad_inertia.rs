//! Inertia and weight of the gel.

use super::block::BodyBlock;
use super::state::{BodyView, IncrementStart};
use super::term::{Assembly, BodyTerm};
use super::time_step::TimeStep;
use crate::body::Body;
use crate::body::pattern::{FIXED, Pattern};
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};
use geometry::Pose;
use glam::{DMat3, DVec3};

/// Masses at the nodes: `m / 2 h2 |x - target|2` with the target `x0 + h v0 + h2 g` of each node, in the world.
#[derive(Debug, Clone)]
pub struct PadInertia {
    /// Mass per node, kg.
    mass: Vec<f64>,
    total: f64,
    /// Gravity, world axes, m/s2.
    gravity: DVec3,
    /// World position at the last accepted state, m, and velocity there, m/s.
    position: Vec<DVec3>,
    velocity: Vec<DVec3>,
    step: TimeStep,
    /// Target of each node, hand frame at the end of the step, m.
    target: Vec<DVec3>,
}

impl PadInertia {
    /// Creates the inertia of a pad at rest in the world. `view` is the state, `hand` that of the hand.
    pub fn new(body: &Body, density: f64, gravity: DVec3, hand: Pose, view: &BodyView) -> Self {
        let mass: Vec<f64> = body.lumped_volume().into_iter().map(|v| v * density).collect();
        let position: Vec<DVec3> = view.x.iter().map(|x| hand.transform(*x + view.offset)).collect();
        let target = vec![DVec3::ZERO; position.len()];
        let velocity = target.clone();
        let step = TimeStep { size: 1.0, hand };
        Self { total: mass.iter().sum(), mass, gravity, position, velocity, step, target }
    }
}

impl BodyTerm for PadInertia {
    fn energy(&self, _: &Body, view: &BodyView) -> f64 {
        let each = self.mass.iter().zip(view.x).zip(&self.target);
        let sum: f64 = each.map(|((m, x), t)| m * (*x + view.offset - *t).length_squared()).sum();
        0.5 * sum / (self.step.size * self.step.size)
    }

    fn assemble(&mut self, body: &Body, view: &BodyView, _: Assembly, block: &mut BodyBlock) {
        let pattern = body.pattern();
        let unknowns = pattern.unknowns();
        let scale = 1.0 / (self.step.size * self.step.size);
        for (i, (mass, x)) in self.mass.iter().zip(view.x).enumerate() {
            let (stiffness, force) = (mass * scale, (*x + view.offset - self.target[i]) * (mass * scale));
            block.gradient[i] += force;
            let position = pattern.position[i];
            if position != FIXED && block.wants_hessian() {
                let slot = pattern.slot(i as u32, i as u32);
                Pattern::add(&mut block.values, slot, &(DMat3::IDENTITY * stiffness));
            }
            if let Some(c) = view.travel_column {
                if position != FIXED && block.wants_hessian() {
                    let row = c * unknowns + 3 * position as usize;
                    let column = view.closing * stiffness;
                    block.coupling[row..row + 3].iter_mut().zip(column.to_array()).for_each(|(a, b)| *a += b);
                }
                block.rigid.gradient[c] += force.dot(view.closing);
                if block.wants_hessian() {
                    block.rigid.hessian[c][c] += stiffness;
                }
            }
        }
        block.rigid.force_scale += self.total * self.gravity.length();
    }

    fn begin_increment(&mut self, from: &IncrementStart) {
        let Some(step) = from.step else { return };
        self.step = step;
        let h = step.size;
        for ((target, x), v) in self.target.iter_mut().zip(&self.position).zip(&self.velocity) {
            *target = step.hand.inverse_transform(*x + *v * h + self.gravity * (h * h));
        }
    }

    fn commit(&mut self, _: &Body, view: &BodyView) {
        for ((x, v), now) in self.position.iter_mut().zip(&mut self.velocity).zip(view.x) {
            let now = self.step.hand.transform(*now + view.offset);
            *v = (now - *x) / self.step.size;
            *x = now;
        }
    }

    fn save_state(&self, history: &mut StateWriter) {
        history.write(&self.position);
        history.write(&self.velocity);
    }

    fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        history.read_into(&mut self.position)?;
        history.read_into(&mut self.velocity)
    }
}
