//! Keeps elements from turning inside out where no quadrature point looks.
//!
//! The elastic energy is summed over points inside an element. Pressed hard by an edge, a 10-node tetrahedron may be sound at all of
//! them and yet inverted at a corner. One with a small det F at a node gets a barrier at its nodes, a part of the law of the gel that is
//! zero from `FELT` on; the others pay nothing.

use super::body::Body;
use super::pattern::Pattern;
use super::state::View;
use super::term::{Block, BodyTerm};
use crate::element::{Kernel, Stiffness, TET10_NODES};
use crate::material::{Dilatation, Material, Moduli, Tangent};
use glam::{DMat3, DVec3};
use std::any::Any;
use std::collections::BTreeSet;

/// The elements that have a barrier.
#[derive(Debug, Clone, Default)]
pub struct Upright {
    elements: BTreeSet<usize>,
}

/// det F at a node below which the barrier of its element resists.
const FELT: f64 = 0.02;
/// Stiffness of the barrier over the shear modulus of the gel.
const STIFFNESS: f64 = 1.0;

/// `k/2 (1 - J/FELT)^2` below [`FELT`].
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
        let missing = (1.0 - (1.0 + theta) / FELT).max(0.0);
        let (k, bends) = (STIFFNESS * self.0.mu, f64::from(missing > 0.0));
        [0.5 * k * missing * missing, -k * missing / FELT, bends * k / (FELT * FELT)]
    }

    fn moduli(&self) -> &Moduli {
        &self.0
    }
}

impl Upright {
    /// With a barrier for every element of `body` that needs one at positions `x`, m.
    pub fn new(body: &Body, x: &[DVec3]) -> Self {
        let mut barriers = Self::default();
        barriers.extend(body, x);
        barriers
    }

    /// Whether an element of `body` needs one at positions `x`, m.
    pub fn is_needed(body: &Body, x: &[DVec3]) -> bool {
        body.min_det_f_at_nodes(x) < FELT
    }

    /// Adds the gradient of the barriers' energy at positions `x` (m), N per node.
    pub fn add_gradient(&self, body: &Body, x: &[DVec3], gradient: &mut [DVec3]) {
        let barrier = barrier(body);
        for (rest, x, nodes) in self.elements.iter().filter_map(|e| body.quadratic(*e, x)) {
            let mut local = [DVec3::ZERO; 10];
            kernel(&barrier).add_gradient(rest, &x, &mut local);
            nodes.iter().zip(local).for_each(|(&i, g)| gradient[i as usize] += g);
        }
    }

    /// Gives a barrier to the elements that need one at positions `x`; true if none is new.
    fn extend(&mut self, body: &Body, x: &[DVec3]) -> bool {
        if !Self::is_needed(body, x) {
            return true;
        }
        let (barrier, before) = (barrier(body), self.elements.len());
        let small = |e: &usize| {
            let nodes = body.quadratic(*e, x).map(|(rest, x, _)| kernel(&barrier).deformation(rest, &x));
            nodes.is_some_and(|f| f.iter().any(|f| f.determinant() < FELT))
        };
        self.elements.extend((0..body.element_count()).filter(small));
        self.elements.len() == before
    }
}

fn barrier(body: &Body) -> Barrier {
    Barrier(*body.material.moduli())
}

fn kernel(barrier: &Barrier) -> Kernel<'_, 10, 10> {
    Kernel { shape: &TET10_NODES, material: barrier, mean_dilatation: false }
}

impl BodyTerm for Upright {
    fn energy(&self, body: &Body, view: &View) -> f64 {
        let barrier = barrier(body);
        let elements = self.elements.iter().filter_map(|e| body.quadratic(*e, view.x));
        elements.map(|(rest, x, _)| kernel(&barrier).energy(rest, &x)).sum()
    }

    fn assemble(&mut self, body: &Body, view: &View, project: bool, block: &mut Block) {
        self.add_gradient(body, view.x, &mut block.gradient);
        if !block.hessian {
            return;
        }
        let barrier = barrier(body);
        for (rest, x, nodes) in self.elements.iter().filter_map(|e| body.quadratic(*e, view.x)) {
            let mut sum = Stiffness::default();
            kernel(&barrier).stiffness([rest], &[x], project, &mut sum);
            for a in 0..10 {
                for b in a..10 {
                    Pattern::add(&mut block.values, body.pattern().slot(nodes[a], nodes[b]), &sum.block(0, a, b));
                }
            }
        }
    }

    fn satisfied(&mut self, body: &Body, view: &View) -> bool {
        self.extend(body, view.x)
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}
