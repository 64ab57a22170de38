//! Elastic forces of a recorded state, from the strain energy density of the gel and the node positions alone.
//!
//! Stresses are difference quotients of the energy density, which reveals a wrong derivative in the solver. The audit
//! shares with the solver this density, the constants of the inversion barrier and the choice of mean dilatation; its
//! shape functions, quadrature and assembly are independent.

use super::inversion::EDGES;
use glam::{DMat3, DVec3};
use mech::body::Body;
use mech::material::Dilatation;
use mech::potential::inversion_barrier::{BARRIER_STIFFNESS, BARRIER_THRESHOLD};
use rayon::prelude::*;
use record::ElementNodes;

/// Step of the difference quotients in the deformation gradient; truncation and rounding errors are then both below
/// 1e-9 of the shear modulus.
const STEP: f64 = 1e-5;

/// Computes the gradient of the elastic energy of `body` with `elements` and nodes at `x` (m): N per node.
pub fn elastic_gradient(body: &Body, elements: &ElementNodes, x: &[DVec3]) -> Vec<DVec3> {
    let nodes: Vec<&[u32]> = elements.nodes().chunks_exact(elements.width()).collect();
    let forces: Vec<_> = nodes.par_iter().map(|nodes| element_gradient(body, nodes, x)).collect();
    let mut gradient = vec![DVec3::ZERO; x.len()];
    for (nodes, forces) in nodes.iter().zip(forces) {
        nodes.iter().zip(forces).for_each(|(i, f)| gradient[*i as usize] += f);
    }
    gradient
}

/// Computes the volume that each node of `body` carries under a uniform body force (the integral of its shape
/// function), m3.
pub fn nodal_volume(body: &Body, elements: &ElementNodes) -> Vec<f64> {
    let (width, mut volume) = (elements.width(), vec![0.0; body.rest.len()]);
    let share = |k: usize| match (width, k) {
        (4, _) => 0.25,
        (_, 0..4) => -0.05,
        _ => 0.2,
    };
    for nodes in elements.nodes().chunks_exact(width) {
        let [a, b, c, d] = std::array::from_fn(|k| body.rest[nodes[k] as usize]);
        let whole = (b - a).cross(c - a).dot(d - a) / 6.0;
        nodes.iter().enumerate().for_each(|(k, i)| volume[*i as usize] += whole * share(k));
    }
    volume
}

/// Kinematics at a point of an element.
struct Point {
    /// Deformation gradient.
    f: DMat3,
    /// Gradients of the shape functions in the reference configuration, 1/m.
    shape: [DVec3; 10],
}

impl Point {
    /// Evaluates an element with nodes at reference positions `rest` and at `x`, m, at the barycentric coordinates `l`.
    fn new(rest: &[DVec3], x: &[DVec3], l: [f64; 4]) -> Self {
        let slopes = shape_derivatives(rest.len(), l);
        let sum = |at: &[DVec3]| at.iter().zip(&slopes).fold(DMat3::ZERO, |m, (p, s)| m + outer(*p, *s));
        let inverse = sum(rest).inverse();
        Self { f: sum(x) * inverse, shape: slopes.map(|s| inverse.transpose() * s) }
    }

    /// Adds the nodal forces of the first Piola-Kirchhoff stress `p` (Pa) in `volume` (m3).
    fn add(&self, p: DMat3, volume: f64, forces: &mut [DVec3]) {
        forces.iter_mut().zip(&self.shape).for_each(|(force, shape)| *force += p * *shape * volume);
    }
}

/// Computes the gradient of the energy of one element, N per node of it.
fn element_gradient(body: &Body, nodes: &[u32], x: &[DVec3]) -> Vec<DVec3> {
    let rest: Vec<DVec3> = nodes.iter().map(|i| body.rest[*i as usize]).collect();
    let x: Vec<DVec3> = nodes.iter().map(|i| x[*i as usize]).collect();
    let volume = (rest[1] - rest[0]).cross(rest[2] - rest[0]).dot(rest[3] - rest[0]) / 6.0;
    let point = |l| Point::new(&rest, &x, l);
    let points: Vec<Point> = quadrature(nodes.len()).into_iter().map(point).collect();
    let (law, each) = (body.material.as_ref(), volume / points.len() as f64);
    let measure = |f: &DMat3| match law.dilatation() {
        Dilatation::Determinant => (f.determinant() - 1.0, f.inverse().transpose() * f.determinant()),
        Dilatation::Trace => (f.x_axis.x + f.y_axis.y + f.z_axis.z - 3.0, DMat3::IDENTITY),
    };
    let dilatation: Vec<_> = points.iter().map(|point| measure(&point.f)).collect();
    let mean = dilatation.iter().map(|(theta, _)| theta).sum::<f64>() / points.len() as f64;
    let slope = |theta: f64| (law.volumetric(theta + STEP)[0] - law.volumetric(theta - STEP)[0]) / (2.0 * STEP);
    let mut forces = vec![DVec3::ZERO; nodes.len()];
    for (point, (theta, direction)) in points.iter().zip(dilatation) {
        let pressure = match body.mean_dilatation {
            // One pressure per element, and at most the shear modulus as stiffness against fluctuations about the mean.
            true => slope(mean) + law.moduli().mu.min(law.volumetric(mean)[2]) * (theta - mean),
            false => slope(theta),
        };
        let stress = difference(|f| law.distortional_energy(f), &point.f) + direction * pressure;
        point.add(stress, each, &mut forces);
    }
    if nodes.len() == 10 {
        let corner = |k: usize| std::array::from_fn(|i| f64::from(i == k));
        let middle = |ends: [usize; 2]| std::array::from_fn(|i| if ends.contains(&i) { 0.5 } else { 0.0 });
        let on_nodes = (0..4).map(corner).chain(EDGES.into_iter().map(middle)).map(|l| (l, 0.1 * volume));
        for (l, volume) in on_nodes.chain([([0.25; 4], volume)]) {
            let point = point(l);
            let j = point.f.determinant();
            if j < BARRIER_THRESHOLD {
                let slope = -BARRIER_STIFFNESS * law.moduli().mu * (1.0 - j / BARRIER_THRESHOLD) / BARRIER_THRESHOLD;
                point.add(point.f.inverse().transpose() * (j * slope), volume, &mut forces);
            }
        }
    }
    forces
}

/// Differentiates an energy density with respect to the deformation gradient by central differences, Pa.
fn difference(energy: impl Fn(&DMat3) -> f64, f: &DMat3) -> DMat3 {
    let at = f.to_cols_array();
    let slope = |k: usize| {
        let beside = |way: f64| {
            let mut near = at;
            near[k] += way;
            energy(&DMat3::from_cols_array(&near))
        };
        (beside(STEP) - beside(-STEP)) / (2.0 * STEP)
    };
    DMat3::from_cols_array(&std::array::from_fn(slope))
}

/// Returns the barycentric coordinates of quadrature points of equal weight: the centre of a 4-node tetrahedron, the
/// rule of degree 2 for 10 nodes (Keast 1986).
fn quadrature(width: usize) -> Vec<[f64; 4]> {
    let inner = (5.0 - 5.0_f64.sqrt()) / 20.0;
    match width {
        4 => vec![[0.25; 4]],
        _ => (0..4).map(|k| std::array::from_fn(|i| if i == k { 1.0 - 3.0 * inner } else { inner })).collect(),
    }
}

/// Returns the derivatives of the shape functions of 4 or 10 nodes with respect to the barycentric coordinates 1 to 3;
/// coordinate 0 is one minus their sum.
fn shape_derivatives(width: usize, l: [f64; 4]) -> [DVec3; 10] {
    let unit = [DVec3::splat(-1.0), DVec3::X, DVec3::Y, DVec3::Z];
    std::array::from_fn(|a| match (width, a) {
        (4, 0..4) => unit[a],
        (4, _) => DVec3::ZERO,
        (_, 0..4) => unit[a] * (4.0 * l[a] - 1.0),
        _ => {
            let [i, j] = EDGES[a - 4];
            unit[i] * (4.0 * l[j]) + unit[j] * (4.0 * l[i])
        }
    })
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}
