//! Nodal contact forces under which the linear response of the pad conforms to the object.
//!
//! The forces of a rigid equilibrium are linear between corner nodes. Projected gradient steps with momentum (Beck and
//! Teboulle 2009) relax them towards forces under which every node in contact is displaced as the object prescribes, no
//! node is in tension or exceeds Coulomb's limit, and the resultants are unchanged. A few steps are enough; the network
//! learns the rest.
//!
//! Loads are iterated together, [`LANES`] at a time, so that loops over them vectorise; their responses are one matrix
//! product.

use super::compliance::Compliance;
use super::contact_point::ContactPoint;
use crate::matrix::product::{PackedMatrix, RowsView, multiply_lanes};
use glam::DVec3;
use mech::contact::coulomb::{cone_factor, slips};
use pulp::{Arch, NullaryFnOnce};

/// Number of gradient steps.
const STEPS: usize = 10;
/// Number of trial slidings of the pad in each step.
const SLIDES: usize = 4;
/// Gap, over the largest depth, up to which nodes take part.
const REACH: f64 = 0.3;
/// Number of loads that are iterated together.
pub const LANES: usize = crate::matrix::product::LANES;

/// One number per load.
type Lanes = [f64; LANES];

/// Face node under load, pad frame; lengths over the thickness, forces over `E t^2`.
#[derive(Debug, Clone, Copy)]
pub struct ContactNode {
    /// Contact point around the node.
    pub point: ContactPoint,
    /// Normal of the object; the same under all loads.
    pub normal: DVec3,
    /// Depth along the normal that the object prescribes at the contact point; negative is a gap.
    pub prescribed_depth: f64,
    /// Displacement along the face that the object prescribes at the contact point.
    pub prescribed_sliding: DVec3,
    /// Initial force.
    pub force: DVec3,
}

/// Computes the contact of at most [`LANES`] loads of the face with these `nodes` under Coulomb's `friction`. Returns,
/// for each, the forces on all nodes, and the additional closing of the pad that they require.
pub fn projected_contact(
    compliance: &Compliance,
    nodes: &[u32],
    face: &[Vec<ContactNode>],
    friction: f64,
) -> Vec<(Vec<DVec3>, f64)> {
    let deepest: Vec<f64> =
        face.iter().map(|load| load.iter().map(|n| n.prescribed_depth).fold(0.0, f64::max)).collect();
    // Participation of each node, from zero to one: smooth, so that the forces do not jump when a node comes near.
    let part = |(load, deepest): (&Vec<ContactNode>, &f64)| -> Vec<f64> {
        let of = |node: &ContactNode| {
            let near = (node.prescribed_depth / (REACH * deepest.max(f64::MIN_POSITIVE)) + 1.0).clamp(0.0, 1.0);
            if node.normal == DVec3::ZERO { 0.0 } else { near * near * (3.0 - 2.0 * near) }
        };
        load.iter().map(of).collect()
    };
    let part: Vec<Vec<f64>> = face.iter().zip(&deepest).map(part).collect();
    let count = face.first().map_or(0, Vec::len);
    let near: Vec<usize> = (0..count).filter(|i| part.iter().any(|load| load[*i] > 0.0)).collect();
    let mut done: Vec<(Vec<DVec3>, f64)> =
        face.iter().map(|load| (load.iter().map(|n| n.force).collect(), 0.0)).collect();
    if near.is_empty() {
        return done;
    }
    let mut iteration = ProjectedGradient::new((compliance, nodes), face, &near, &deepest, &part, friction);
    for step in 0..STEPS {
        iteration.update_displacements();
        let momentum = (step + 1) as f64 / (step + 4) as f64;
        Arch::new().dispatch(Step { iteration: &mut iteration, momentum });
    }
    for (load, (forces, additional_closing)) in done.iter_mut().enumerate() {
        if part[load].iter().all(|part| *part == 0.0) {
            continue;
        }
        forces.fill(DVec3::ZERO);
        for (k, i) in near.iter().enumerate().filter(|(_, i)| part[load][**i] > 0.0) {
            let force = DVec3::from_array([0, 1, 2].map(|a| iteration.nodes[k].force[a][load]));
            face[load][*i].point.weights().for_each(|(node, weight)| forces[node] += force * weight);
        }
        *additional_closing = iteration.additional_closing[load];
    }
    done
}

/// Node under several loads; zero under those in which it does not take part.
#[derive(Debug, Clone, Default)]
struct Node {
    normal: [f64; 3],
    /// Inverse of the normal response of the node to a force on itself, times its participation.
    stiff: Lanes,
    prescribed_depth: Lanes,
    prescribed_sliding: [Lanes; 3],
    force: [Lanes; 3],
    /// Force extrapolated by the momentum.
    ahead: [Lanes; 3],
    /// Results of a step: pressure without and then with the additional closing of the pad; force along the face.
    pressure: Lanes,
    along: [Lanes; 3],
}

/// State of the iteration over all loads.
struct ProjectedGradient {
    nodes: Vec<Node>,
    /// Response (nodes * 3, nodes * 3): component of a node under a force component.
    matrix: Vec<f32>,
    /// Step size.
    size: Lanes,
    /// Sums that are preserved: pressure, and force along the face across the closing direction.
    whole: Lanes,
    along: [Lanes; 2],
    deepest: Lanes,
    /// Additional closing of the pad, and its sliding.
    additional_closing: Lanes,
    sliding: [Lanes; 2],
    loads: usize,
    /// Coulomb's coefficient.
    friction: f64,
    /// Forces (nodes * 3, [`LANES`]), and the displacements that they cause.
    forces: PackedMatrix,
    moved: Vec<f32>,
}

impl ProjectedGradient {
    fn new(
        (compliance, nodes): (&Compliance, &[u32]),
        face: &[Vec<ContactNode>],
        near: &[usize],
        deepest: &[f64],
        takes_part: &[Vec<f64>],
        friction: f64,
    ) -> Self {
        let m = near.len();
        let mut matrix = Vec::with_capacity(9 * m * m);
        let points: Vec<ContactPoint> = near.iter().map(|i| face[0][*i].point).collect();
        for own in &points {
            for a in 0..3 {
                let row = own.response(compliance, nodes, a);
                if row.is_empty() {
                    matrix.resize(matrix.len() + 3 * m, 0.0);
                } else {
                    points.iter().for_each(|other| matrix.extend(other.interpolate_components(&row)));
                }
            }
        }
        let mut all = Self {
            nodes: vec![Node::default(); m],
            size: [1.0; LANES],
            whole: [0.0; LANES],
            along: [[0.0; LANES]; 2],
            deepest: [0.0; LANES],
            additional_closing: [0.0; LANES],
            sliding: [[0.0; LANES]; 2],
            loads: face.len(),
            friction,
            forces: PackedMatrix::default(),
            moved: vec![0.0; 3 * m * LANES],
            matrix,
        };
        all.deepest[..deepest.len()].copy_from_slice(deepest);
        let mut part = vec![[0.0; LANES]; m];
        for (k, (node, i)) in all.nodes.iter_mut().zip(near).enumerate() {
            node.normal = face[0][*i].normal.to_array();
            let n = node.normal;
            let own = |a: usize, b: usize| f64::from(all.matrix[(3 * k + a) * 3 * m + 3 * k + b]);
            let give: f64 = (0..3).map(|a| (0..3).map(|b| n[a] * n[b] * own(a, b)).sum::<f64>()).sum();
            let stiff = 1.0 / give.max(1e-9);
            for load in 0..face.len() {
                let at = &face[load][*i];
                part[k][load] = takes_part[load][*i];
                if part[k][load] == 0.0 {
                    continue;
                }
                node.stiff[load] = stiff * part[k][load];
                node.prescribed_depth[load] = at.prescribed_depth;
                for a in 0..3 {
                    node.prescribed_sliding[a][load] = at.prescribed_sliding[a];
                    node.force[a][load] = part[k][load] * at.force[a];
                }
            }
            node.ahead = node.force;
        }
        // The force of nodes that do not take part passes to the others.
        for (load, nodes) in face.iter().enumerate() {
            for at in nodes {
                let pressure = at.force.dot(at.normal);
                all.whole[load] += pressure;
                (0..2).for_each(|a| all.along[a][load] += at.force[a] - at.normal[a] * pressure);
            }
        }
        let sums = Arch::new().dispatch(Sums { matrix: &all.matrix, part: &part });
        // The step size is the inverse of a bound on the largest eigenvalue of the scaled matrix.
        let mut bound = [1.0; LANES];
        for (sums, node) in sums.iter().zip(&all.nodes) {
            for l in 0..LANES {
                bound[l] = f64::max(bound[l], sums[l] / 3.0 * node.stiff[l]);
            }
        }
        all.size = bound.map(|b| 1.0 / b);
        all
    }

    /// Computes the displacements under the extrapolated forces.
    fn update_displacements(&mut self) {
        let nodes = &self.nodes;
        self.forces.fill(3 * nodes.len(), LANES, |r, load| nodes[r / 3].ahead[r % 3][load] as f32);
        let a = RowsView { data: &self.matrix, stride: 3 * nodes.len(), count: 3 * nodes.len() };
        multiply_lanes(a, &self.forces, self.loads, &mut self.moved);
    }

    /// Takes a step, and extrapolates the forces for the next one.
    #[inline(always)]
    fn step(&mut self, momentum: f64) {
        let moved = self.moved.as_chunks::<LANES>().0.as_chunks::<3>().0;
        for (node, u) in self.nodes.iter_mut().zip(moved) {
            let n = node.normal;
            for l in 0..LANES {
                let at = |v: &[Lanes; 3]| n[0] * v[0][l] + n[1] * v[1][l] + n[2] * v[2][l];
                let given = n[0] * f64::from(u[0][l]) + n[1] * f64::from(u[1][l]) + n[2] * f64::from(u[2][l]);
                let gain = self.size[l] * node.stiff[l];
                node.pressure[l] = at(&node.ahead) + gain * (node.prescribed_depth[l] - given);
            }
        }
        // Newton's method on a piecewise linear function preserves the sum of the pressures.
        for _ in 0..4 {
            let (mut sum, mut slope) = ([0.0; LANES], [0.0; LANES]);
            for node in &self.nodes {
                for l in 0..LANES {
                    let gain = self.size[l] * node.stiff[l];
                    let p = node.pressure[l] + gain * self.additional_closing[l];
                    sum[l] += if p > 0.0 { p } else { 0.0 };
                    slope[l] += if p > 0.0 { gain } else { 0.0 };
                }
            }
            for l in 0..LANES {
                let lacks = (self.whole[l] - sum[l]) / slope[l];
                self.additional_closing[l] += if slope[l] > 0.0 { lacks } else { self.deepest[l] };
            }
        }
        for (node, u) in self.nodes.iter_mut().zip(moved) {
            let n = node.normal;
            for l in 0..LANES {
                let gain = self.size[l] * node.stiff[l];
                let p = node.pressure[l] + gain * self.additional_closing[l];
                node.pressure[l] = if p > 0.0 { p } else { 0.0 };
                let wanted =
                    [0, 1, 2].map(|a| node.ahead[a][l] + (node.prescribed_sliding[a][l] - f64::from(u[a][l])) * gain);
                let out = n[0] * wanted[0] + n[1] * wanted[1] + n[2] * wanted[2];
                (0..3).for_each(|a| node.along[a][l] = wanted[a] - n[a] * out);
            }
        }
        self.slide();
        for node in &mut self.nodes {
            for a in 0..3 {
                for l in 0..LANES {
                    let force = node.normal[a] * node.pressure[l] + node.along[a][l];
                    node.ahead[a][l] = force + (force - node.force[a][l]) * momentum;
                    node.force[a][l] = force;
                }
            }
        }
    }
    /// Finds the sliding of the pad across the closing direction that preserves the sum of the forces along the face,
    /// by Newton's method with step halving (Coulomb's limit makes the sum nonlinear), and stores these forces. Where
    /// the sum exceeds what friction can carry, it is not reached.
    #[inline(always)]
    fn slide(&mut self) {
        let (mut step, mut least) = ([[0.0; LANES]; 2], [f64::INFINITY; LANES]);
        let mut tried = self.sliding;
        for _ in 0..SLIDES {
            // Deficit of the sum, and the derivative of the sum: xx, xy, yy.
            let (mut lacks, mut slope) = (self.along, [[0.0; LANES]; 3]);
            for node in &self.nodes {
                let n = node.normal;
                for l in 0..LANES {
                    let gain = self.size[l] * node.stiff[l];
                    let (f, part, bends) = node.sliding_force(l, gain, self.friction, [tried[0][l], tried[1][l]]);
                    lacks[0][l] -= f[0];
                    lacks[1][l] -= f[1];
                    slope[0][l] += gain * part * (1.0 - n[0] * n[0] - bends * f[0] * f[0]);
                    slope[1][l] -= gain * part * (n[0] * n[1] + bends * f[0] * f[1]);
                    slope[2][l] += gain * part * (1.0 - n[1] * n[1] - bends * f[1] * f[1]);
                }
            }
            for l in 0..LANES {
                let lack = lacks[0][l] * lacks[0][l] + lacks[1][l] * lacks[1][l];
                let better = lack < least[l];
                let [xx, xy, yy] = [0, 1, 2].map(|k| slope[k][l]);
                let determinant = xx * yy - xy * xy;
                let bounded = determinant > 1e-9 * (xx + yy) * (xx + yy);
                let newton = [yy * lacks[0][l] - xy * lacks[1][l], xx * lacks[1][l] - xy * lacks[0][l]];
                for a in 0..2 {
                    self.sliding[a][l] = if better { tried[a][l] } else { self.sliding[a][l] };
                    let whole = if bounded { newton[a] / determinant } else { 0.0 };
                    step[a][l] = if better { whole } else { 0.5 * step[a][l] };
                    tried[a][l] = self.sliding[a][l] + step[a][l];
                }
                least[l] = if better { lack } else { least[l] };
            }
        }
        for node in &mut self.nodes {
            for l in 0..LANES {
                let gain = self.size[l] * node.stiff[l];
                let (f, ..) = node.sliding_force(l, gain, self.friction, [self.sliding[0][l], self.sliding[1][l]]);
                (0..3).for_each(|a| node.along[a][l] = f[a]);
            }
        }
    }
}

/// [`ProjectedGradient::step`] as a struct that is compiled for the vector instructions of the processor; a closure of
/// this size would not be.
struct Step<'a> {
    iteration: &'a mut ProjectedGradient,
    momentum: f64,
}

impl NullaryFnOnce for Step<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.iteration.step(self.momentum);
    }
}

/// Sums of the magnitudes of the responses of each node to all others, weighted by their participation `part`: (nodes,
/// loads).
struct Sums<'a> {
    matrix: &'a [f32],
    part: &'a [Lanes],
}

impl NullaryFnOnce for Sums<'_> {
    type Output = Vec<Lanes>;

    #[inline(always)]
    fn call(self) -> Vec<Lanes> {
        let m = self.part.len();
        let mut sums = vec![[0.0_f64; LANES]; m];
        for (k, part) in self.part.iter().enumerate() {
            let [x, y, z] = [0, 1, 2].map(|a| &self.matrix[(3 * k + a) * 3 * m..(3 * k + a + 1) * 3 * m]);
            for (j, sums) in sums.iter_mut().enumerate() {
                let size: f32 = (3 * j..3 * j + 3).map(|c| x[c].abs() + y[c].abs() + z[c].abs()).sum();
                let size = f64::from(size);
                sums.iter_mut().zip(part).for_each(|(sum, part)| *sum += size * part);
            }
        }
        sums
    }
}

impl Node {
    /// Computes the force along the face after sliding by `sliding`, under Coulomb's limit; the factor by which the
    /// limit reduces it; and the inverse square of the limit where it is reached, zero elsewhere.
    #[inline(always)]
    fn sliding_force(&self, load: usize, gain: f64, friction: f64, sliding: [f64; 2]) -> ([f64; 3], f64, f64) {
        let n = self.normal;
        let out = n[0] * sliding[0] + n[1] * sliding[1];
        let sliding = [sliding[0] - n[0] * out, sliding[1] - n[1] * out, -n[2] * out];
        let wanted = [0, 1, 2].map(|a| self.along[a][load] + gain * sliding[a]);
        let length = (wanted[0] * wanted[0] + wanted[1] * wanted[1] + wanted[2] * wanted[2]).sqrt();
        let most = friction * self.pressure[load];
        let part = cone_factor(length, most);
        let bends = if slips(length, most) && most > 0.0 { 1.0 / (most * most) } else { 0.0 };
        (wanted.map(|w| w * part), part, bends)
    }
}
