//! One soft body: mesh and law. It is immutable and shared; the caller holds the state.

mod analysis;
mod assembly;
pub mod cholesky;
mod derived;
mod elements;
pub mod locking;
pub mod pattern;
pub mod single_precision;

use self::analysis::Analysis;
use self::assembly::{AddGradient, AddStiffness, ElementLoop, Energy, LeastDeterminant};
use self::cholesky::Symbolic;
pub use self::elements::Elements;
use self::elements::gather;
use self::pattern::{Pattern, Slot};
use crate::element::{Kernel, RestTet, ShapeFunctions, TET4, TET10, TET10_CENTER, TET10_NODES};
use crate::material::{Material, von_mises};
use base::error::Result;
use glam::{DMat3, DVec3};
use pulp::Arch;
use std::sync::Arc;

/// A discretised soft body in its reference configuration.
#[derive(Debug)]
pub struct Body {
    /// Reference (undeformed) position of every node, m.
    pub rest: Vec<DVec3>,
    /// Node lists.
    pub elements: Elements,
    /// Flags of the nodes without unknowns.
    pub fixed: Vec<bool>,
    /// Law of the gel.
    pub material: Arc<dyn Material>,
    /// Flag: each element has one pressure.
    pub mean_dilatation: bool,
    pub(crate) analysis: Arc<Analysis>,
    tets: Vec<RestTet>,
}

/// Stress recovered from a configuration.
#[derive(Debug, Clone, Default)]
pub struct BodyStress {
    /// Von Mises stress of the element-averaged Cauchy tensor, Pa.
    pub element: Vec<f64>,
    /// Von Mises stress of the nodal Cauchy tensor (extrapolated from the quadrature points, volume-weighted), Pa.
    pub node: Vec<f64>,
}

/// Evaluates `$body` with `$nodes` and `$kernel` bound to the node lists and the kernel of the mesh's order.
macro_rules! per_order {
    ($self:expr, $nodes:ident, $kernel:ident, $body:expr) => {
        match &$self.elements {
            Elements::Linear($nodes) => {
                let $kernel = $self.kernel(&TET4);
                $body
            }
            Elements::Quadratic($nodes) => {
                let $kernel = $self.kernel(&TET10);
                $body
            }
        }
    };
}

impl Body {
    /// Creates the body whose nodes have the reference positions `rest`.
    pub fn new(
        rest: Vec<DVec3>,
        elements: Elements,
        fixed: Vec<bool>,
        material: Arc<dyn Material>,
        mean_dilatation: bool,
    ) -> Self {
        let tet = |n: &[u32]| RestTet::new(std::array::from_fn(|k| rest[n[k] as usize]));
        let tets = elements.lists().into_iter().map(tet).collect();
        Self { rest, elements, fixed, material, mean_dilatation, analysis: Arc::default(), tets }
    }

    fn kernel<'a, const N: usize, const Q: usize>(&'a self, shape: &'a ShapeFunctions<N, Q>) -> Kernel<'a, N, Q> {
        Kernel { shape, material: self.material.as_ref(), mean_dilatation: self.mean_dilatation }
    }

    /// Stiffness pattern and elimination order.
    pub fn pattern(&self) -> &Pattern {
        self.analysis.pattern(&self.elements, &self.fixed)
    }

    /// Symbolic Cholesky analysis.
    ///
    /// # Errors
    /// Fails if the factorisation cannot be analysed (too large for memory).
    pub fn symbolic(&self) -> Result<&Arc<Symbolic>> {
        self.analysis.symbolic(&self.elements, &self.fixed)
    }

    /// Number of unknowns: three per free node.
    pub fn unknowns(&self) -> usize {
        3 * self.fixed.iter().filter(|fixed| !**fixed).count()
    }

    /// Slots of the node pairs of each element, each unordered pair once.
    pub(crate) fn slots(&self) -> &[Slot] {
        self.analysis.slots(&self.elements, &self.fixed)
    }

    /// Number of elements.
    pub fn element_count(&self) -> usize {
        self.tets.len()
    }

    /// Returns element `e` if it has 10 nodes: its reference geometry, its node positions among `x`, and its nodes.
    pub fn quadratic(&self, e: usize, x: &[DVec3]) -> Option<(&RestTet, [DVec3; 10], &[u32; 10])> {
        match &self.elements {
            Elements::Quadratic(nodes) => Some((&self.tets[e], gather(&nodes[e], x), &nodes[e])),
            Elements::Linear(_) => None,
        }
    }

    /// Elastic energy at positions `x`, J; `+inf` if an element is inverted and the law is not defined there.
    pub fn energy(&self, x: &[DVec3]) -> f64 {
        per_order!(
            self,
            nodes,
            kernel,
            Arch::new().dispatch(Energy(ElementLoop { kernel, nodes, tets: &self.tets, x }))
        )
    }

    /// Adds the gradient of the elastic energy, N, per node.
    pub fn add_gradient(&self, x: &[DVec3], gradient: &mut [DVec3]) {
        per_order!(self, nodes, kernel, {
            Arch::new()
                .dispatch(AddGradient { elements: ElementLoop { kernel, nodes, tets: &self.tets, x }, gradient });
        });
    }

    /// Adds gradient (N, per node) and stiffness (N/m, in [`Pattern`] storage). `project` makes the
    /// tangent of every point positive semidefinite.
    pub fn add_stiffness(&self, x: &[DVec3], project: bool, gradient: &mut [DVec3], values: &mut [f64]) {
        per_order!(self, nodes, kernel, {
            let (elements, slots) = (ElementLoop { kernel, nodes, tets: &self.tets, x }, self.slots());
            Arch::new().dispatch(AddStiffness { elements, slots, project, gradient, values });
        });
    }

    /// Smallest determinant of the deformation gradient at positions `x`, over all quadrature points. For 10-node
    /// elements it includes the corners, the midpoints of the edges and the centre, where an inversion would otherwise
    /// be undetected.
    pub fn min_det_f(&self, x: &[DVec3]) -> f64 {
        let points = per_order!(self, nodes, kernel, {
            Arch::new().dispatch(LeastDeterminant(ElementLoop { kernel, nodes, tets: &self.tets, x }))
        });
        points.min(self.min_det_f_at(&TET10_NODES, x)).min(self.min_det_f_at(&TET10_CENTER, x))
    }

    /// Returns the element with the smallest determinant of [`Body::min_det_f`]; None for a body without elements.
    pub fn most_inverted(&self, x: &[DVec3]) -> Option<usize> {
        let least = |f: &[DMat3]| f.iter().map(DMat3::determinant).fold(f64::INFINITY, f64::min);
        let mut det: Vec<f64> = per_order!(self, nodes, kernel, {
            let of = |(n, rest)| least(&kernel.deformation(rest, &gather(n, x)));
            nodes.iter().zip(&self.tets).map(of).collect()
        });
        for (e, det) in det.iter_mut().enumerate() {
            if let Some((rest, x, _)) = self.quadratic(e, x) {
                let nodes = self.kernel(&TET10_NODES).deformation(rest, &x);
                *det = det.min(least(&nodes)).min(least(&self.kernel(&TET10_CENTER).deformation(rest, &x)));
            }
        }
        (0..det.len()).min_by(|a, b| det[*a].total_cmp(&det[*b]))
    }

    /// Smallest determinant of the deformation gradient of 10-node elements at the points of `shape`, at positions `x`;
    /// `+inf` if there are none.
    pub fn min_det_f_at<const Q: usize>(&self, shape: &ShapeFunctions<10, Q>, x: &[DVec3]) -> f64 {
        let Elements::Quadratic(nodes) = &self.elements else { return f64::INFINITY };
        let material = self.material.as_ref();
        let kernel = Kernel { shape, material, mean_dilatation: false };
        Arch::new().dispatch(LeastDeterminant(ElementLoop { kernel, nodes, tets: &self.tets, x }))
    }

    /// Stress at positions `x`.
    pub fn stress(&self, x: &[DVec3]) -> BodyStress {
        let [element, node] = self.cauchy(x).map(|all| all.iter().map(von_mises).collect());
        BodyStress { element, node }
    }

    /// Cauchy stress at positions `x`, Pa: mean of every element, and of every node, extrapolated from the quadrature
    /// points and weighted with the volume.
    pub fn cauchy(&self, x: &[DVec3]) -> [Vec<DMat3>; 2] {
        let mut node = vec![(DMat3::ZERO, 0.0); x.len()];
        let mut element = Vec::with_capacity(self.tets.len());
        per_order!(self, nodes, kernel, {
            for (n, rest) in nodes.iter().zip(&self.tets) {
                let cauchy = kernel.stress(rest, &gather(n, x));
                let mean = cauchy.iter().fold(DMat3::ZERO, |s, c| s + *c) * (1.0 / cauchy.len() as f64);
                element.push(mean);
                for (a, &i) in n.iter().enumerate() {
                    let (sum, weight) = &mut node[i as usize];
                    *sum += extrapolate(&cauchy, &mean, a) * rest.volume;
                    *weight += rest.volume;
                }
            }
        });
        let mean = |(s, w): &(DMat3, f64)| if *w > 0.0 { *s * (1.0 / w) } else { DMat3::ZERO };
        [element, node.iter().map(mean).collect()]
    }

    /// Lumped volume per node, positive and with the sum of the body's: the diagonal of the consistent mass matrix,
    /// scaled per element (Hinton, Rock & Zienkiewicz 1976), m3.
    pub fn lumped_volume(&self) -> Vec<f64> {
        let mut volume = vec![0.0; self.rest.len()];
        let mut share = |nodes: &[u32], tet: &RestTet, part: &dyn Fn(usize) -> f64| {
            nodes.iter().enumerate().for_each(|(a, &i)| volume[i as usize] += tet.volume * part(a));
        };
        match &self.elements {
            Elements::Linear(e) => e.iter().zip(&self.tets).for_each(|(n, t)| share(n, t, &|_| 0.25)),
            Elements::Quadratic(e) => {
                let part = |a: usize| if a < 4 { 1.0 / 36.0 } else { 4.0 / 27.0 };
                e.iter().zip(&self.tets).for_each(|(n, t)| share(n, t, &part));
            }
        }
        volume
    }

    /// Integral of each node's shape function, m3: the consistent nodal load of a unit body force, negative at the
    /// corners of 10-node tetrahedra.
    pub fn nodal_volume(&self) -> Vec<f64> {
        let mut volume = vec![0.0; self.rest.len()];
        match &self.elements {
            Elements::Linear(e) => {
                for (n, t) in e.iter().zip(&self.tets) {
                    n.iter().for_each(|&i| volume[i as usize] += t.volume / 4.0);
                }
            }
            Elements::Quadratic(e) => {
                // Consistent body-force weights: -1/20 at corners, 1/5 at mid-edges.
                for (n, t) in e.iter().zip(&self.tets) {
                    for (a, &i) in n.iter().enumerate() {
                        volume[i as usize] += t.volume * if a < 4 { -0.05 } else { 0.2 };
                    }
                }
            }
        }
        volume
    }
}

/// Linear extrapolation of quadrature-point tensors to local node `a` (exact for linear fields).
fn extrapolate<const Q: usize>(point: &[DMat3; Q], mean: &DMat3, a: usize) -> DMat3 {
    if Q != 4 {
        return *mean;
    }
    // Point q has barycentric coordinate 0.585 of corner q: its deviation from the mean is scaled to the corner.
    let scale = 1.0 / (0.585_410_196_624_968_5 - 0.138_196_601_125_010_5);
    let corner = |k: usize| *mean + (point[k] - *mean) * scale;
    if a < 4 {
        corner(a)
    } else {
        let [i, j] = crate::element::EDGES[a - 4];
        (corner(i) + corner(j)) * 0.5
    }
}
