//! Viscosity of the gel.

use super::block::BodyBlock;
use super::state::{BodyView, IncrementStart};
use super::term::{Assembly, BodyTerm};
use crate::body::Body;
use crate::body::pattern::FIXED;
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};
use glam::DVec3;
use std::sync::Arc;

/// Energy `tau / 2 h (x - x0)^T K (x - x0)` with the stiffness `K` of the undeformed gel: a Kelvin-Voigt solid whose
/// stress is `C (strain + tau rate)` for small strains. Nodes are relative to their finger, so that a motion of the
/// hand is not damped.
#[derive(Debug, Clone)]
pub struct Viscosity {
    /// Retardation time, s.
    tau: f64,
    /// Lower triangle of K in the body's pattern, N/m.
    stiffness: Arc<[f64]>,
    /// Node positions at the last accepted state, m.
    last: Vec<DVec3>,
    size: f64,
}

impl Viscosity {
    /// Creates the viscosity of a gel with retardation time `tau` (s), at rest at positions `x` (m).
    pub fn new(body: &Body, tau: f64, x: &[DVec3]) -> Self {
        let mut values = vec![0.0; body.pattern().row_idx.len()];
        body.add_stiffness(&body.rest, true, &mut vec![DVec3::ZERO; body.rest.len()], &mut values);
        Self { tau, stiffness: values.into(), last: x.to_vec(), size: 1.0 }
    }

    /// Computes `K (x - x0)` and `x - x0` by unknown.
    fn product(&self, body: &Body, x: &[DVec3]) -> (Vec<f64>, Vec<f64>) {
        let pattern = body.pattern();
        let mut moved = vec![0.0; pattern.unknowns()];
        for ((now, before), &p) in x.iter().zip(&self.last).zip(&pattern.position) {
            if p != FIXED {
                moved[3 * p as usize..3 * p as usize + 3].copy_from_slice(&(*now - *before).to_array());
            }
        }
        let mut force = vec![0.0; moved.len()];
        for c in 0..moved.len() {
            for k in pattern.col_ptr[c]..pattern.col_ptr[c + 1] {
                let (r, v) = (pattern.row_idx[k], self.stiffness[k]);
                force[r] += v * moved[c];
                if r != c {
                    force[c] += v * moved[r];
                }
            }
        }
        (force, moved)
    }
}

impl BodyTerm for Viscosity {
    fn energy(&self, body: &Body, view: &BodyView) -> f64 {
        let (force, moved) = self.product(body, view.x);
        0.5 * self.tau / self.size * force.iter().zip(&moved).map(|(f, u)| f * u).sum::<f64>()
    }

    fn assemble(&mut self, body: &Body, view: &BodyView, _: Assembly, block: &mut BodyBlock) {
        let scale = self.tau / self.size;
        let (force, _) = self.product(body, view.x);
        for (g, &p) in block.gradient.iter_mut().zip(&body.pattern().position) {
            if p != FIXED {
                *g += DVec3::from_slice(&force[3 * p as usize..]) * scale;
            }
        }
        if block.wants_hessian() {
            block.values.iter_mut().zip(self.stiffness.iter()).for_each(|(v, k)| *v += scale * k);
        }
    }

    fn begin_increment(&mut self, from: &IncrementStart) {
        self.size = from.step.map_or(self.size, |step| step.size);
    }

    fn commit(&mut self, _: &Body, view: &BodyView) {
        self.last.copy_from_slice(view.x);
    }

    fn save_state(&self, history: &mut StateWriter) {
        history.write(&self.last);
    }

    fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        history.read_into(&mut self.last)
    }
}
