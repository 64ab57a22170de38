//! Contact forces node by node, under which the pad's linear response follows the object.
//!
//! The forces of an equilibrium are smooth between corners. They are relaxed towards those under which every touching node
//! gives as the object asks, no node pulls or slips, and the sums stay: projected gradient steps with momentum (Beck and Teboulle 2009).
//! A few steps are enough, the network learns the rest.
//!
//! Loads go side by side, [`LANES`] at a time: what one does to a number, all do, and the response to all of them is one
//! product of matrices.

use super::compliance::Compliance;
use crate::kernel::product::{Packed, RowsView, respond};
use glam::DVec3;
use pulp::Arch;

/// Number of steps.
const STEPS: usize = 10;
/// Distance from touching from which on nodes begin to take part, over the deepest.
const REACH: f64 = 0.3;
/// Number of loads that are iterated together.
pub const LANES: usize = crate::kernel::product::LANES;

/// One number per load.
type Lanes = [f64; LANES];

/// A face node under load, pad frame, over the thickness and `E t^2`.
#[derive(Debug, Clone, Copy)]
pub struct Touching {
    /// Node of the pad.
    pub node: usize,
    /// Normal of the object; the same under all loads.
    pub normal: DVec3,
    /// Depth along the normal that the object asks of the node; negative is a gap.
    pub pressed: f64,
    /// Displacement along the face that the object asks of the node.
    pub dragged: DVec3,
    /// Force to start from.
    pub force: DVec3,
}

/// Computes the contact of at most [`LANES`] loads under Coulomb's `friction`. Returns for each the forces on all of `face`, and how much farther the pad
/// must be closed for them.
pub fn projected_contact(compliance: &Compliance, face: &[Vec<Touching>], friction: f64) -> Vec<(Vec<DVec3>, f64)> {
    let deepest: Vec<f64> = face.iter().map(|load| load.iter().map(|n| n.pressed).fold(0.0, f64::max)).collect();
    // The part that each node takes, from zero to one: so a node that comes near does not make the forces jump.
    let part = |(load, deepest): (&Vec<Touching>, &f64)| -> Vec<f64> {
        let of = |node: &Touching| {
            let near = (node.pressed / (REACH * deepest.max(f64::MIN_POSITIVE)) + 1.0).clamp(0.0, 1.0);
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
    let mut iteration = ProjectedGradient::new(compliance, face, &near, &deepest, &part, friction);
    for step in 0..STEPS {
        iteration.respond();
        let momentum = (step + 1) as f64 / (step + 4) as f64;
        Arch::new().dispatch(|| iteration.step(momentum));
    }
    for (load, (forces, closer)) in done.iter_mut().enumerate() {
        for (k, i) in near.iter().enumerate().filter(|(_, i)| part[load][**i] > 0.0) {
            forces[*i] = DVec3::from_array([0, 1, 2].map(|a| iteration.nodes[k].force[a][load]));
        }
        *closer = iteration.closer[load];
    }
    done
}

/// A node under several loads; zero under those that it takes no part in.
#[derive(Debug, Clone, Default)]
struct Node {
    normal: [f64; 3],
    /// Inverse of the response of the node to a force on itself, times the part that it takes.
    stiff: Lanes,
    pressed: Lanes,
    dragged: [Lanes; 3],
    force: [Lanes; 3],
    /// The force with its momentum.
    ahead: [Lanes; 3],
    /// Results of a step: pressure if the pad comes no closer, then pressure; force along the face.
    pressure: Lanes,
    along: [Lanes; 3],
}

/// State of the iteration over all loads.
struct ProjectedGradient {
    nodes: Vec<Node>,
    /// Response (nodes * 3, nodes * 3): component of a node under a force component.
    matrix: Vec<f32>,
    /// Size of a step.
    size: Lanes,
    /// Sums that stay: pressure, force along the face.
    whole: Lanes,
    along: [Lanes; 3],
    deepest: Lanes,
    /// How much farther the pad closes, and slides.
    closer: Lanes,
    slid: [Lanes; 3],
    loads: usize,
    /// Coulomb's coefficient.
    friction: f64,
    /// Forces (nodes * 3, [`LANES`]), and the displacement that they cause.
    forces: Packed,
    moved: Vec<f32>,
}

impl ProjectedGradient {
    fn new(
        compliance: &Compliance,
        face: &[Vec<Touching>],
        near: &[usize],
        deepest: &[f64],
        takes_part: &[Vec<f64>],
        friction: f64,
    ) -> Self {
        let m = near.len();
        let mut matrix = Vec::with_capacity(9 * m * m);
        for i in near {
            for a in 0..3 {
                match compliance.row(face[0][*i].node as u32, a) {
                    Some(row) => near.iter().for_each(|j| matrix.extend_from_slice(&row[3 * j..3 * j + 3])),
                    None => matrix.resize(matrix.len() + 3 * m, 0.0),
                }
            }
        }
        let mut all = Self {
            nodes: vec![Node::default(); m],
            size: [1.0; LANES],
            whole: [0.0; LANES],
            along: [[0.0; LANES]; 3],
            deepest: [0.0; LANES],
            closer: [0.0; LANES],
            slid: [[0.0; LANES]; 3],
            loads: face.len(),
            friction,
            forces: Packed::default(),
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
                node.pressed[load] = at.pressed;
                let pressure = at.force.dot(at.normal);
                all.whole[load] += pressure;
                for a in 0..3 {
                    node.dragged[a][load] = at.dragged[a];
                    node.force[a][load] = at.force[a];
                    all.along[a][load] += at.force[a] - n[a] * pressure;
                }
            }
            node.ahead = node.force;
        }
        let matrix = &all.matrix;
        let mut sums = vec![[0.0_f64; LANES]; m];
        Arch::new().dispatch(|| {
            for (k, part) in part.iter().enumerate() {
                let [x, y, z] = [0, 1, 2].map(|a| &matrix[(3 * k + a) * 3 * m..(3 * k + a + 1) * 3 * m]);
                for (j, sums) in sums.iter_mut().enumerate() {
                    let size: f32 = (3 * j..3 * j + 3).map(|c| x[c].abs() + y[c].abs() + z[c].abs()).sum();
                    let size = f64::from(size);
                    sums.iter_mut().zip(part).for_each(|(sum, part)| *sum += size * part);
                }
            }
        });
        // A bound of the largest eigenvalue of the scaled matrix gives the step.
        let mut bound = [1.0; LANES];
        for (sums, node) in sums.iter().zip(&all.nodes) {
            for l in 0..LANES {
                bound[l] = f64::max(bound[l], sums[l] / 3.0 * node.stiff[l]);
            }
        }
        all.size = bound.map(|b| 1.0 / b);
        all
    }

    /// Computes the displacement under the forces ahead.
    fn respond(&mut self) {
        let nodes = &self.nodes;
        self.forces.fill(3 * nodes.len(), LANES, |r, load| nodes[r / 3].ahead[r % 3][load] as f32);
        let a = RowsView { data: &self.matrix, stride: 3 * nodes.len(), count: 3 * nodes.len() };
        respond(a, &self.forces, self.loads, &mut self.moved);
    }

    /// Takes a step, and computes the forces ahead of the next one.
    #[inline(always)]
    fn step(&mut self, momentum: f64) {
        let moved = self.moved.as_chunks::<LANES>().0.as_chunks::<3>().0;
        for (node, u) in self.nodes.iter_mut().zip(moved) {
            let n = node.normal;
            for l in 0..LANES {
                let at = |v: &[Lanes; 3]| n[0] * v[0][l] + n[1] * v[1][l] + n[2] * v[2][l];
                let given = n[0] * f64::from(u[0][l]) + n[1] * f64::from(u[1][l]) + n[2] * f64::from(u[2][l]);
                let gain = self.size[l] * node.stiff[l];
                node.pressure[l] = at(&node.ahead) + gain * (node.pressed[l] - given);
            }
        }
        // Newton's method on a piecewise linear function: the sum of the pressures stays.
        for _ in 0..4 {
            let (mut sum, mut slope) = ([0.0; LANES], [0.0; LANES]);
            for node in &self.nodes {
                for l in 0..LANES {
                    let gain = self.size[l] * node.stiff[l];
                    let p = node.pressure[l] + gain * self.closer[l];
                    sum[l] += if p > 0.0 { p } else { 0.0 };
                    slope[l] += if p > 0.0 { gain } else { 0.0 };
                }
            }
            for l in 0..LANES {
                let lacks = (self.whole[l] - sum[l]) / slope[l];
                self.closer[l] += if slope[l] > 0.0 { lacks } else { self.deepest[l] };
            }
        }
        let (mut gains, mut carried) = ([0.0; LANES], [[0.0; LANES]; 3]);
        for (node, u) in self.nodes.iter_mut().zip(moved) {
            let n = node.normal;
            for l in 0..LANES {
                let gain = self.size[l] * node.stiff[l];
                let p = node.pressure[l] + gain * self.closer[l];
                let p = if p > 0.0 { p } else { 0.0 };
                node.pressure[l] = p;
                let wanted = [0, 1, 2]
                    .map(|a| node.ahead[a][l] + (node.dragged[a][l] + self.slid[a][l] - f64::from(u[a][l])) * gain);
                let out = n[0] * wanted[0] + n[1] * wanted[1] + n[2] * wanted[2];
                let wanted = [0, 1, 2].map(|a| wanted[a] - n[a] * out);
                let length = wanted.iter().map(|w| w * w).sum::<f64>().sqrt();
                // Coulomb's limit.
                let most = self.friction * p;
                let part = if length > most { most / length } else { 1.0 };
                gains[l] += if p > 0.0 { gain } else { 0.0 };
                for a in 0..3 {
                    node.along[a][l] = wanted[a] * part;
                    carried[a][l] += node.along[a][l];
                }
            }
        }
        // The sum of the forces along the face comes back to what it was, and hardly moves those that slip.
        for a in 0..3 {
            for l in 0..LANES {
                self.slid[a][l] += (self.along[a][l] - carried[a][l]) / gains[l].max(1e-9);
            }
        }
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
}
