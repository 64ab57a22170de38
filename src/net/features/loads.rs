//! Features of a load: the rigid-object equilibrium under it, and the projected contact, node by node.

use super::GraspFeatures;
use super::parity::Parity::{self, Even, X, XY, Y};
use crate::features::rows;
use crate::linear_response::GraspLoad;
use crate::linear_response::balance::{ObjectBalance, PadLoad};
use crate::linear_response::projected_gradient::{ContactNode, LANES, projected_contact};
use crate::linear_response::rigid_equilibrium::Rest;
use geometry::Wrench;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Features of a node at a load. From the equilibrium: penetration required by the object over depth (negative for a
/// gap), penetration, fraction of the force, displacement over depth. From the projected contact: fraction of the
/// force, tangential over normal force, and the linear response over depth with its gradient along x and y.
pub const NODE_LOAD: [Parity; 18] = [Even, Even, Even, X, Y, Even, Even, X, Y, X, Y, Even, Even, XY, X, XY, Even, Y];
/// Features of a pad at a load: logarithm and cube root of the force, depth, effective contact area, centre of
/// pressure, tangential force and twist over the force, travel over depth, additional travel of the projected contact
/// over depth, motion of the object over depth, force and torque of weight and push on the object over the force.
pub const PAD_LOAD: [Parity; 23] =
    [Even, Even, Even, Even, X, Y, X, Y, XY, Even, Even, X, Y, Even, Y, X, XY, X, Y, Even, Y, X, XY];

/// Fraction of the force that regularises the ratio of tangential to normal force.
const FAINT: f64 = 1e-3;
/// Largest ratio of a tangential to a normal force: where the surface of the object is perpendicular to the face, it
/// would be unbounded.
const LARGEST_TANGENTIAL: f64 = 3.0;

/// Features of some load levels of a grasp, ordered by level, then pad, then node.
#[derive(Debug, Clone, Default)]
pub struct LoadFeatures {
    /// Features of nodes (levels * pads * face nodes, [`NODE_LOAD`]).
    pub node: Vec<f32>,
    /// Features of pads (levels * pads, [`PAD_LOAD`]).
    pub pad: Vec<f32>,
    /// Force per finger over `E t^2`, and push on the object (force over `E t^2`, torque over `E t^3`): (levels).
    pub load: Vec<GraspLoad>,
    /// Flags: a free object is still supported and does not move: (levels).
    pub held: Vec<bool>,
    /// Pressing force of each pad over `E t^2`: (levels * pads).
    pub pressing: Vec<f64>,
    /// Mean displacement of the nodes, weighted by their forces, m: (levels * pads).
    pub depth: Vec<f64>,
    /// Travel of the equilibrium, m: (levels * pads).
    pub travel: Vec<f64>,
    /// Motion of the object in the equilibrium, m and rad, in the frame of each pad: (levels * pads, 6).
    pub motion: Vec<f64>,
    /// Equilibrium conditions of a free object between two pads: (levels); empty otherwise.
    pub balance: Vec<Arc<ObjectBalance>>,
}

impl LoadFeatures {
    /// Returns the features of the levels with the indices `wanted`.
    pub fn levels(&self, wanted: &[usize]) -> Self {
        let count = self.load.len();
        Self {
            node: rows(&self.node, count, wanted),
            pad: rows(&self.pad, count, wanted),
            load: rows(&self.load, count, wanted),
            held: rows(&self.held, count, wanted),
            pressing: rows(&self.pressing, count, wanted),
            depth: rows(&self.depth, count, wanted),
            travel: rows(&self.travel, count, wanted),
            motion: rows(&self.motion, count, wanted),
            balance: wanted.iter().filter_map(|level| self.balance.get(*level)).cloned().collect(),
        }
    }

    /// Returns the ratio of pressing force over `E t^2` to depth over thickness: (levels * pads).
    pub fn scale(&self, features: &GraspFeatures) -> Vec<f32> {
        let t = features.graph.thickness;
        self.pressing.iter().zip(&self.depth).map(|(force, depth)| (force * t / depth) as f32).collect()
    }
}

/// Projected contact of a pad under a load; values per face node, over the thickness and `E t^2`.
struct ProjectedContact {
    /// Required state of each node according to the equilibrium.
    touching: Vec<ContactNode>,
    /// Displacement under the forces of the equilibrium.
    moved: Vec<DVec3>,
    /// Contact force.
    force: Vec<DVec3>,
    /// Additional travel of the pad that it requires.
    closer: f64,
    /// Displacement under these forces.
    given: Vec<DVec3>,
}

impl GraspFeatures {
    /// Computes the features at these loads, in N and N m.
    pub fn loads(&self, all: &[GraspLoad]) -> LoadFeatures {
        let t = self.graph.thickness;
        let mut loads = LoadFeatures::default();
        for some in all.chunks(LANES) {
            let some: Vec<GraspLoad> = some.iter().map(|load| load.over(self.unit_force(), t)).collect();
            let rests: Vec<Rest> = some.par_iter().map(|load| self.equilibrium.rest(load)).collect();
            let contacts: Vec<Vec<ProjectedContact>> =
                (0..self.pads).into_par_iter().map(|p| self.contacts(p, &rests)).collect();
            for (k, (load, rest)) in some.iter().zip(&rests).enumerate() {
                loads.load.push(*load);
                loads.held.push(self.equilibrium.holds(load));
                (0..self.pads).for_each(|p| self.load_pad(p, rest, &contacts[p][k], &mut loads));
            }
            if let (true, [left, right]) = (self.equilibrium.free, &contacts[..]) {
                let of = |k: usize| {
                    let pads = [(0, &left[k]), (1, &right[k])]
                        .map(|(p, contact)| self.pressed(p, &some[k], &rests[k], contact));
                    let balance = ObjectBalance::new(&pads, self.equilibrium.load_about_midpoint(&rests[k], &some[k]));
                    let held = self.equilibrium.holds(&some[k]);
                    Arc::new(if held { balance.supported() } else { balance })
                };
                loads.balance.par_extend((0..some.len()).into_par_iter().map(of));
            }
        }
        loads.depth.iter_mut().chain(&mut loads.travel).for_each(|d| *d *= t);
        loads
    }

    /// Computes the projected contact of pad `p`, starting from the forces of the equilibrium.
    fn contacts(&self, p: usize, rests: &[Rest]) -> Vec<ProjectedContact> {
        let graph = &self.graph;
        let count = graph.face.len();
        let pressing: Vec<Vec<DVec3>> = rests.iter().map(|rest| graph.basis.on_face(&rest.force[p], count)).collect();
        let moved = graph.compliance.on_face(&graph.face, &pressing);
        let touching = |load: usize| -> Vec<ContactNode> {
            let asked = self.equilibrium.pressed(p, &rests[load]);
            let of = |i: usize| {
                let (force, moved, (pressed, normal)) = (pressing[load][i], moved[load][i], asked[i]);
                let dragged = moved - normal * moved.dot(normal);
                ContactNode { node: graph.face[i] as usize, normal, pressed, dragged, force }
            };
            (0..count).map(of).collect()
        };
        let touching: Vec<Vec<ContactNode>> = (0..rests.len()).map(touching).collect();
        let (force, closer): (Vec<Vec<DVec3>>, Vec<f64>) =
            projected_contact(&graph.compliance, &touching, self.model.friction).into_iter().unzip();
        let given = graph.compliance.on_face(&graph.face, &force);
        let parts = touching.into_iter().zip(moved).zip(force.into_iter().zip(closer)).zip(given);
        let of =
            |(((touching, moved), (force, closer)), given)| ProjectedContact { touching, moved, force, closer, given };
        parts.map(of).collect()
    }

    /// Returns the pressing force of pad `p`, and where and in what parts it acts.
    fn pressed(&self, p: usize, load: &GraspLoad, rest: &Rest, contact: &ProjectedContact) -> PadLoad {
        let places =
            self.graph.rest.iter().zip(&contact.given).map(|(at, moved)| self.equilibrium.place(p, *at, *moved, rest));
        PadLoad {
            force: self.equilibrium.finger_force(p, load, rest),
            rotation: self.to_pad[p].transpose(),
            nodes: places.zip(contact.force.iter().map(|push| -push.z.min(0.0))).collect(),
        }
    }

    /// Appends the features of pad `p` under the last load, all over the thickness and `E t^2`.
    fn load_pad(&self, p: usize, rest: &Rest, contact: &ProjectedContact, loads: &mut LoadFeatures) {
        let (t, to_pad) = (self.graph.thickness, self.to_pad[p]);
        let load = loads.load[loads.load.len() - 1];
        let force = self.equilibrium.finger_force(p, &load, rest);
        let ProjectedContact { touching, moved, force: projected, closer, given } = contact;
        let carried: Vec<f64> = touching.iter().map(|t| t.force.length()).collect();
        let whole = carried.iter().sum::<f64>().max(1e-12);
        let depth = carried.iter().zip(moved).map(|(c, u)| c / whole * u.length()).sum::<f64>().max(1e-9);
        let (mut center, mut uneven, mut pull, mut twist) = (DVec3::ZERO, 0.0, DVec3::ZERO, 0.0);
        for (i, push) in projected.iter().enumerate() {
            let (at, basis, pressed) = (self.graph.rest[i] / t, touching[i].force / force, touching[i].pressed);
            // The offset makes the ratio vanish smoothly at the edge of the contact, where the normal force vanishes.
            let sideways = *push / (-push.z.min(0.0) + FAINT * force);
            let sideways = sideways.truncate().clamp_length_max(LARGEST_TANGENTIAL);
            let [x, y, z] = (moved[i] / depth).to_array();
            center += at * (carried[i] / whole);
            uneven += basis.z.min(0.0).powi(2) / (self.graph.area[i] / (t * t));
            pull += basis;
            twist += at.x * basis.y - at.y * basis.x;
            let row = [(pressed / depth).max(-4.0), pressed.max(0.0), carried[i] / whole, x, y, z];
            let share = [-push.z.min(0.0) / force, sideways.x, sideways.y];
            let (mut along_x, mut along_y) = (DVec3::ZERO, DVec3::ZERO);
            for (j, g) in &self.graph.gradient[i] {
                along_x += given[*j as usize] * (g.x * t);
                along_y += given[*j as usize] * (g.y * t);
            }
            let given = given[i].to_array().map(|u| u / depth);
            let given = given.into_iter().chain(along_x.to_array()).chain(along_y.to_array());
            loads.node.extend(row.into_iter().chain(share).chain(given).map(|v| v as f32));
        }
        // Area of a uniform pressure with the same sum of squares; weakly loaded nodes hardly contribute.
        let area = pull.z.powi(2) / uneven.max(1e-12);
        let travel = rest.travel[p];
        let (shift, turn) = (to_pad * rest.shift, to_pad * rest.rotation.to_scaled_axis());
        let row = [
            force.ln(),
            force.cbrt(),
            depth,
            area,
            center.x,
            center.y,
            pull.x,
            pull.y,
            twist,
            travel / depth,
            *closer / depth,
        ];
        let motion = shift.to_array().into_iter().chain(turn.to_array()).map(|v| v / depth);
        let Wrench { force: pull, torque: moment } = self.equilibrium.load_about_centre(&load);
        let pull = [pull, moment].map(|pull| (to_pad * pull / force).clamp_length_max(LARGEST_TANGENTIAL).to_array());
        loads.pad.extend(row.into_iter().chain(motion).chain(pull.into_iter().flatten()).map(|v| v as f32));
        loads.pressing.push(force);
        loads.depth.push(depth);
        loads.travel.push(travel);
        loads.motion.extend((shift * t).to_array().into_iter().chain(turn.to_array()));
    }
}
