//! Keeps elements from turning inside out where no quadrature point looks.
//!
//! The elastic energy is summed over points inside an element. Pressed hard by an edge, a 10-node tetrahedron may be sound at all of
//! them and yet inverted at a corner. An element that converges so gets a barrier at its nodes, zero until det F falls below
//! [`FELT`]; the others pay nothing.

use super::body::Body;
use super::pattern::Pattern;
use super::state::View;
use super::term::{Block, BodyTerm};
use crate::element::{Kernel, TET10_NODES};
use crate::material::{Dilatation, Material, Moduli, Tangent};
use glam::{DMat3, DVec3};
use std::any::Any;
use std::collections::BTreeMap;

/// Barriers of the elements that need one.
#[derive(Debug, Clone, Default)]
pub struct Upright {
    /// Per element its stiffness over the shear modulus.
    barriers: BTreeMap<usize, f64>,
}

/// det F below which a barrier resists.
const FELT: f64 = 0.1;
/// Smallest det F at the nodes of a state that is accepted.
const SMALLEST: f64 = 0.02;
/// How much stiffer a barrier gets that did not suffice.
const STRONGER: f64 = 4.0;

/// `k/2 (1 - J/FELT)^2` below [`FELT`].
#[derive(Debug)]
struct Barrier {
    moduli: Moduli,
    stiffness: f64,
}

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
        let (k, bends) = (self.stiffness, f64::from(missing > 0.0));
        [0.5 * k * missing * missing, -k * missing / FELT, bends * k / (FELT * FELT)]
    }

    fn moduli(&self) -> &Moduli {
        &self.moduli
    }
}

impl Upright {
    /// The elements with a barrier and its law.
    fn barriers<'a>(&'a self, body: &'a Body) -> impl Iterator<Item = (usize, Barrier)> + 'a {
        let moduli = *body.material.moduli();
        self.barriers.iter().map(move |(&e, k)| (e, Barrier { moduli, stiffness: k * moduli.mu }))
    }
}

fn kernel(material: &dyn Material) -> Kernel<'_, 10, 10> {
    Kernel { shape: &TET10_NODES, material, mean_dilatation: false }
}

impl BodyTerm for Upright {
    fn energy(&self, body: &Body, view: &View) -> f64 {
        self.barriers(body)
            .filter_map(|(e, barrier)| body.quadratic(e, view.x).map(|(rest, x, _)| kernel(&barrier).energy(rest, &x)))
            .sum()
    }

    fn assemble(&mut self, body: &Body, view: &View, project: bool, block: &mut Block) {
        for (e, barrier) in self.barriers(body) {
            let Some((rest, x, nodes)) = body.quadratic(e, view.x) else { continue };
            let mut gradient = x.map(|_| DVec3::ZERO);
            match block.hessian {
                true => {
                    let mut stiffness = [[DMat3::ZERO; 10]; 10];
                    kernel(&barrier).stiffness(rest, &x, project, &mut gradient, &mut stiffness);
                    for (a, row) in stiffness.iter().enumerate() {
                        for (b, entry) in row.iter().enumerate().skip(a) {
                            Pattern::add(&mut block.values, body.pattern.slot(nodes[a], nodes[b]), entry);
                        }
                    }
                }
                false => kernel(&barrier).add_gradient(rest, &x, &mut gradient),
            }
            nodes.iter().zip(gradient).for_each(|(&i, g)| block.gradient[i as usize] += g);
        }
    }

    fn satisfied(&mut self, body: &Body, view: &View) -> bool {
        let barrier = Barrier { moduli: *body.material.moduli(), stiffness: 0.0 };
        let mut held = true;
        for e in 0..body.element_count() {
            let Some((rest, x, _)) = body.quadratic(e, view.x) else { continue };
            if kernel(&barrier).min_det_f(rest, &x) < SMALLEST {
                self.barriers.entry(e).and_modify(|k| *k *= STRONGER).or_insert(1.0);
                held = false;
            }
        }
        held
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}
