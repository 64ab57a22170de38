//! Barrier against the inversion of elements away from their quadrature points.
//!
//! The elastic energy is summed over points inside an element. Under the pressure of an edge, a 10-node tetrahedron may
//! be valid at all of them and yet inverted at a corner or at its centre. An element with a small det F at a node gets
//! a barrier at its nodes, one with a small det F at its centre a barrier there: a volumetric energy that is zero for
//! det F above `BARRIER_THRESHOLD`. Other elements cost nothing.

use super::block::BodyBlock;
use super::state::BodyView;
use super::term::{Assembly, BodyTerm};
use crate::body::Body;
use crate::body::pattern::Pattern;
use crate::element::{Kernel, ShapeFunctions, Stiffness, TET10_CENTER, TET10_NODES};
use crate::material::{Dilatation, Material, Moduli, Tangent};
use base::error::Result;
use base::saved_state::{StateReader, StateWriter};
use glam::{DMat3, DVec3};
use std::collections::BTreeSet;

/// Elements that have a barrier at the points of `shape`.
#[derive(Debug, Clone)]
pub struct InversionBarrier<const Q: usize> {
    shape: &'static ShapeFunctions<10, Q>,
    elements: BTreeSet<usize>,
}

/// Creates the terms against the inversion of elements at their nodes and at their centres; initially, no element has a
/// barrier.
pub fn inversion_barrier() -> (InversionBarrier<10>, InversionBarrier<1>) {
    (InversionBarrier::at(&TET10_NODES), InversionBarrier::at(&TET10_CENTER))
}

/// Returns true if an element of `body` needs a barrier at positions `x`, m.
pub fn needs_inversion_barrier(body: &Body, x: &[DVec3]) -> bool {
    let (nodes, centers) = inversion_barrier();
    nodes.is_needed(body, x) || centers.is_needed(body, x)
}

/// Value of det F below which the barrier is active.
pub const BARRIER_THRESHOLD: f64 = 0.02;
/// Stiffness of the barrier over the shear modulus of the gel.
pub const BARRIER_STIFFNESS: f64 = 1.0;

/// Law with the energy `k/2 (1 - J/BARRIER_THRESHOLD)^2` below [`BARRIER_THRESHOLD`].
#[derive(Debug)]
struct Barrier(Moduli);

impl Material for Barrier {
    fn name(&self) -> &'static str {
        "barrier"
    }

    fn dilatation(&self) -> Dilatation {
        Dilatation::Determinant
    }

    fn distortional_energy(&self, _: &DMat3) -> f64 {
        0.0
    }

    fn distortional_stress(&self, _: &DMat3) -> DMat3 {
        DMat3::ZERO
    }

    fn distortional_tangent(&self, _: &DMat3) -> Tangent {
        [[0.0; 9]; 9]
    }

    fn volumetric(&self, theta: f64) -> [f64; 3] {
        // The dilatation is J - 1.
        let missing = (1.0 - (1.0 + theta) / BARRIER_THRESHOLD).max(0.0);
        let (k, bends) = (BARRIER_STIFFNESS * self.0.mu, f64::from(missing > 0.0));
        [
            0.5 * k * missing * missing,
            -k * missing / BARRIER_THRESHOLD,
            bends * k / (BARRIER_THRESHOLD * BARRIER_THRESHOLD),
        ]
    }

    fn moduli(&self) -> &Moduli {
        &self.0
    }
}

impl<const Q: usize> InversionBarrier<Q> {
    fn at(shape: &'static ShapeFunctions<10, Q>) -> Self {
        Self { shape, elements: BTreeSet::new() }
    }

    /// Returns true if an element of `body` needs a barrier at positions `x`, m.
    fn is_needed(&self, body: &Body, x: &[DVec3]) -> bool {
        body.min_det_f_at(self.shape, x) < BARRIER_THRESHOLD
    }

    fn kernel<'a>(&'a self, barrier: &'a Barrier) -> Kernel<'a, 10, Q> {
        Kernel { shape: self.shape, material: barrier, mean_dilatation: false }
    }

    /// Adds the gradient of the barriers' energy at positions `x` (m), N per node.
    fn add_gradient(&self, body: &Body, x: &[DVec3], gradient: &mut [DVec3]) {
        let barrier = barrier(body);
        for (rest, x, nodes) in self.elements.iter().filter_map(|e| body.quadratic(*e, x)) {
            let mut local = [DVec3::ZERO; 10];
            self.kernel(&barrier).add_gradient(rest, &x, &mut local);
            nodes.iter().zip(local).for_each(|(&i, g)| gradient[i as usize] += g);
        }
    }

    /// Adds a barrier to the elements that need one at positions `x`; returns true if none is new.
    fn extend(&mut self, body: &Body, x: &[DVec3]) -> bool {
        if !self.is_needed(body, x) {
            return true;
        }
        let (barrier, before) = (barrier(body), self.elements.len());
        let kernel = self.kernel(&barrier);
        let small = |e: &usize| {
            let nodes = body.quadratic(*e, x).map(|(rest, x, _)| kernel.deformation(rest, &x));
            nodes.is_some_and(|f| f.iter().any(|f| f.determinant() < BARRIER_THRESHOLD))
        };
        let crushed: Vec<usize> = (0..body.element_count()).filter(small).collect();
        self.elements.extend(crushed);
        self.elements.len() == before
    }
}

fn barrier(body: &Body) -> Barrier {
    Barrier(*body.material.moduli())
}

impl<const Q: usize> BodyTerm for InversionBarrier<Q> {
    fn energy(&self, body: &Body, view: &BodyView) -> f64 {
        let barrier = barrier(body);
        let elements = self.elements.iter().filter_map(|e| body.quadratic(*e, view.x));
        elements.map(|(rest, x, _)| self.kernel(&barrier).energy(rest, &x)).sum()
    }

    fn assemble(&mut self, body: &Body, view: &BodyView, how: Assembly, block: &mut BodyBlock) {
        self.add_gradient(body, view.x, &mut block.gradient);
        if !block.wants_hessian() {
            return;
        }
        let barrier = barrier(body);
        for (rest, x, nodes) in self.elements.iter().filter_map(|e| body.quadratic(*e, view.x)) {
            let mut sum = Stiffness::default();
            self.kernel(&barrier).stiffness([rest], &[x], how.project, &mut sum);
            for a in 0..10 {
                for b in a..10 {
                    Pattern::add(&mut block.values, body.pattern().slot(nodes[a], nodes[b]), &sum.block(0, a, b));
                }
            }
        }
    }

    fn enforce_constraints(&mut self, body: &Body, view: &BodyView) -> bool {
        self.extend(body, view.x)
    }

    fn save_state(&self, history: &mut StateWriter) {
        history.write(&self.elements);
    }

    fn restore_state(&mut self, history: &mut StateReader) -> Result<()> {
        self.elements = history.read()?;
        Ok(())
    }
}
