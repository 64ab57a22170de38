//! Loops over all elements of a body, as callable structs: these are compiled for the widest vector registers of the
//! processor, which closures of this size are not.

use super::elements::gather;
use super::pattern::{Pattern, Slot};
use crate::element::{Kernel, RestTet, Stiffness};
use glam::DVec3;
use pulp::NullaryFnOnce;

/// Number of elements whose stiffness is computed together, one per vector lane.
const LANES: usize = 8;

/// All elements of a body at the node positions `x`.
pub(super) struct ElementLoop<'a, const N: usize, const Q: usize> {
    pub kernel: Kernel<'a, N, Q>,
    pub nodes: &'a [[u32; N]],
    pub tets: &'a [RestTet],
    pub x: &'a [DVec3],
}

/// Sum of the energies.
pub(super) struct Energy<'a, const N: usize, const Q: usize>(pub ElementLoop<'a, N, Q>);

impl<const N: usize, const Q: usize> NullaryFnOnce for Energy<'_, N, Q> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let ElementLoop { kernel, nodes, tets, x } = self.0;
        nodes.iter().zip(tets).map(|(n, rest)| kernel.energy(rest, &gather(n, x))).sum()
    }
}

/// Smallest determinant of the deformation gradient.
pub(super) struct LeastDeterminant<'a, const N: usize, const Q: usize>(pub ElementLoop<'a, N, Q>);

impl<const N: usize, const Q: usize> NullaryFnOnce for LeastDeterminant<'_, N, Q> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let ElementLoop { kernel, nodes, tets, x } = self.0;
        kernel.min_det_f(tets, |e, a| x[nodes[e][a] as usize])
    }
}

/// Sum of the gradients.
pub(super) struct AddGradient<'a, const N: usize, const Q: usize> {
    pub elements: ElementLoop<'a, N, Q>,
    pub gradient: &'a mut [DVec3],
}

impl<const N: usize, const Q: usize> NullaryFnOnce for AddGradient<'_, N, Q> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let ElementLoop { kernel, nodes, tets, x } = self.elements;
        for (n, rest) in nodes.iter().zip(tets) {
            let mut local = n.map(|_| DVec3::ZERO);
            kernel.add_gradient(rest, &gather(n, x), &mut local);
            for (&i, g) in n.iter().zip(local) {
                self.gradient[i as usize] += g;
            }
        }
    }
}

/// Sum of the gradients and of the stiffness.
pub(super) struct AddStiffness<'a, const N: usize, const Q: usize> {
    pub elements: ElementLoop<'a, N, Q>,
    pub slots: &'a [Slot],
    pub project: bool,
    pub gradient: &'a mut [DVec3],
    pub values: &'a mut [f64],
}

impl<const N: usize, const Q: usize> NullaryFnOnce for AddStiffness<'_, N, Q> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { elements: ElementLoop { kernel, nodes, tets, x }, slots, project, gradient, values } = self;
        let pairs = slots.len() / nodes.len().max(1);
        let mut sum = Box::<Stiffness<N, LANES>>::default();
        for start in (0..nodes.len()).step_by(LANES) {
            // The last element fills the unused lanes of the last batch.
            let own: [usize; LANES] = std::array::from_fn(|l| (start + l).min(nodes.len() - 1));
            let at = own.map(|e| gather(&nodes[e], x));
            kernel.stiffness(own.map(|e| &tets[e]), &at, project, &mut sum);
            for (l, e) in (start..nodes.len()).take(LANES).enumerate() {
                for (&i, g) in nodes[e].iter().zip(sum.gradient[l]) {
                    gradient[i as usize] += g;
                }
                let mut slot = slots[e * pairs..(e + 1) * pairs].iter();
                for a in 0..N {
                    for (b, &s) in (a..N).zip(&mut slot) {
                        Pattern::add(values, s, &sum.block(l, a, b));
                    }
                }
            }
        }
    }
}
