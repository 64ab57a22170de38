//! Features of a load: the rigid-object equilibrium under it, and the projected contact, node by node.

use super::GraspFeatures;
use super::parity::Parity::{self, Even, X, XY, Y};
use crate::features::select_rows;
use crate::linear_response::GraspLoad;
use crate::linear_response::balance::{ObjectBalance, PadLoad};
use crate::linear_response::projected_gradient::{ContactNode, LANES, projected_contact};
use crate::linear_response::rigid_equilibrium::Equilibrium;
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

/// Column of the fraction of the force in the projected contact, in [`NODE_LOAD`].
pub const PROJECTED_FRACTION: usize = 6;
/// Column of the effective contact area, in [`PAD_LOAD`].
pub const CONTACT_AREA: usize = 3;

/// Fraction of the force that regularises the ratio of tangential to normal force.
const TANGENTIAL_REGULARISATION: f64 = 1e-3;
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
    pub pressing_force: Vec<f64>,
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
    pub fn select_levels(&self, wanted: &[usize]) -> Self {
        let count = self.load.len();
        Self {
            node: select_rows(&self.node, count, wanted),
            pad: select_rows(&self.pad, count, wanted),
            load: select_rows(&self.load, count, wanted),
            held: select_rows(&self.held, count, wanted),
            pressing_force: select_rows(&self.pressing_force, count, wanted),
            depth: select_rows(&self.depth, count, wanted),
            travel: select_rows(&self.travel, count, wanted),
            motion: select_rows(&self.motion, count, wanted),
            balance: wanted.iter().filter_map(|level| self.balance.get(*level)).cloned().collect(),
        }
    }

    /// Returns the ratio of pressing force over `E t^2` to depth over thickness: (levels * pads).
    pub fn scale(&self, features: &GraspFeatures) -> Vec<f32> {
        let t = features.graph.thickness;
        self.pressing_force.iter().zip(&self.depth).map(|(force, depth)| (force * t / depth) as f32).collect()
    }
}

/// Projected contact of a pad under a load; values per face node, over the thickness and `E t^2`.
struct ProjectedContact {
    /// Required state of each node according to the equilibrium.
    nodes: Vec<ContactNode>,
    /// Displacement under the forces of the equilibrium.
    equilibrium_displacement: Vec<DVec3>,
    /// Contact force.
    force: Vec<DVec3>,
    /// Additional travel of the pad that it requires.
    additional_closing: f64,
    /// Displacement under these forces.
    displacement: Vec<DVec3>,
}

impl GraspFeatures {
    /// Computes the features at these loads, in N and N m.
    pub fn loads(&self, all: &[GraspLoad]) -> LoadFeatures {
        let t = self.graph.thickness;
        let mut loads = LoadFeatures::default();
        for some in all.chunks(LANES) {
            let some: Vec<GraspLoad> = some.iter().map(|load| load.dimensionless(self.unit_force(), t)).collect();
            let states: Vec<Equilibrium> = some.par_iter().map(|load| self.equilibrium.equilibrium(load)).collect();
            let contacts: Vec<Vec<ProjectedContact>> =
                (0..self.pads).into_par_iter().map(|p| self.projected_contacts(p, &states)).collect();
            for (k, (load, state)) in some.iter().zip(&states).enumerate() {
                loads.load.push(*load);
                loads.held.push(self.equilibrium.is_held_fixed(load));
                (0..self.pads).for_each(|p| self.append_pad_features(p, state, &contacts[p][k], &mut loads));
            }
            if let (true, [left, right]) = (self.equilibrium.free, &contacts[..]) {
                let of = |k: usize| {
                    let pads = [(0, &left[k]), (1, &right[k])]
                        .map(|(p, contact)| self.pad_load(p, &some[k], &states[k], contact));
                    let balance = ObjectBalance::new(&pads, self.equilibrium.load_about_midpoint(&states[k], &some[k]));
                    let held = self.equilibrium.is_held_fixed(&some[k]);
                    Arc::new(if held { balance.supported() } else { balance })
                };
                loads.balance.par_extend((0..some.len()).into_par_iter().map(of));
            }
        }
        loads.depth.iter_mut().chain(&mut loads.travel).for_each(|d| *d *= t);
        loads
    }

    /// Computes the projected contact of pad `p`, starting from the forces of the equilibrium.
    fn projected_contacts(&self, p: usize, states: &[Equilibrium]) -> Vec<ProjectedContact> {
        let graph = &self.graph;
        let count = graph.face.len();
        let pressing: Vec<Vec<DVec3>> =
            states.iter().map(|state| graph.basis.face_forces(&state.force[p], count)).collect();
        let moved = graph.compliance.face_displacements(&graph.face, &pressing);
        let nodes = |load: usize| -> Vec<ContactNode> {
            let prescribed = self.equilibrium.prescribed_depths(p, &states[load]);
            let of = |i: usize| {
                let (force, point) = (pressing[load][i], self.equilibrium.contact_points[p][i]);
                let (moved, (prescribed_depth, normal)) = (point.interpolate(&moved[load]), prescribed[i]);
                let prescribed_sliding = moved - normal * moved.dot(normal);
                ContactNode { point, normal, prescribed_depth, prescribed_sliding, force }
            };
            (0..count).map(of).collect()
        };
        let nodes: Vec<Vec<ContactNode>> = (0..states.len()).map(nodes).collect();
        let (force, closing): (Vec<Vec<DVec3>>, Vec<f64>) =
            projected_contact(&graph.compliance, &graph.face, &nodes, self.model.friction).into_iter().unzip();
        let displacement = graph.compliance.face_displacements(&graph.face, &force);
        let parts = nodes.into_iter().zip(moved).zip(force.into_iter().zip(closing)).zip(displacement);
        let of = |(((nodes, equilibrium_displacement), (force, additional_closing)), displacement)| ProjectedContact {
            nodes,
            equilibrium_displacement,
            force,
            additional_closing,
            displacement,
        };
        parts.map(of).collect()
    }

    /// Returns the pressing force of pad `p`, and where and in what parts it acts.
    fn pad_load(&self, p: usize, load: &GraspLoad, state: &Equilibrium, contact: &ProjectedContact) -> PadLoad {
        let places = self
            .graph
            .rest
            .iter()
            .zip(&contact.displacement)
            .map(|(at, moved)| self.equilibrium.hand_position(p, *at, *moved, state));
        PadLoad {
            force: self.equilibrium.finger_force(p, load, state),
            rotation: self.to_pad[p].transpose(),
            nodes: places.zip(contact.force.iter().map(|push| -push.z.min(0.0))).collect(),
        }
    }

    /// Appends the features of pad `p` under the last load, all over the thickness and `E t^2`.
    fn append_pad_features(&self, p: usize, state: &Equilibrium, contact: &ProjectedContact, loads: &mut LoadFeatures) {
        let (t, to_pad) = (self.graph.thickness, self.to_pad[p]);
        let load = loads.load[loads.load.len() - 1];
        let force = self.equilibrium.finger_force(p, &load, state);
        let ProjectedContact {
            nodes,
            equilibrium_displacement: moved,
            force: projected,
            additional_closing,
            displacement,
        } = contact;
        let carried: Vec<f64> = nodes.iter().map(|t| t.force.length()).collect();
        let whole = carried.iter().sum::<f64>().max(1e-12);
        let depth = carried.iter().zip(moved).map(|(c, u)| c / whole * u.length()).sum::<f64>().max(1e-9);
        let (mut center, mut uneven, mut pull, mut twist) = (DVec3::ZERO, 0.0, DVec3::ZERO, 0.0);
        for (i, push) in projected.iter().enumerate() {
            let (at, basis, pressed) = (self.graph.rest[i] / t, nodes[i].force / force, nodes[i].prescribed_depth);
            // The offset makes the ratio vanish smoothly at the edge of the contact, where the normal force vanishes.
            let sideways = *push / (-push.z.min(0.0) + TANGENTIAL_REGULARISATION * force);
            let sideways = sideways.truncate().clamp_length_max(LARGEST_TANGENTIAL);
            let [x, y, z] = (moved[i] / depth).to_array();
            center += at * (carried[i] / whole);
            uneven += basis.z.min(0.0).powi(2) / (self.graph.area[i] / (t * t));
            pull += basis;
            twist += at.x * basis.y - at.y * basis.x;
            let row = [(pressed / depth).max(-4.0), pressed.max(0.0), carried[i] / whole, x, y, z];
            let fractions = [-push.z.min(0.0) / force, sideways.x, sideways.y];
            let (mut along_x, mut along_y) = (DVec3::ZERO, DVec3::ZERO);
            for (j, g) in &self.graph.gradient[i] {
                along_x += displacement[*j as usize] * (g.x * t);
                along_y += displacement[*j as usize] * (g.y * t);
            }
            let given = displacement[i].to_array().map(|u| u / depth);
            let given = given.into_iter().chain(along_x.to_array()).chain(along_y.to_array());
            loads.node.extend(row.into_iter().chain(fractions).chain(given).map(|v| v as f32));
        }
        // Area of a uniform pressure with the same sum of squares; weakly loaded nodes hardly contribute.
        let area = pull.z.powi(2) / uneven.max(1e-12);
        let travel = state.travel[p];
        let (shift, turn) = (to_pad * state.translation, to_pad * state.rotation.to_scaled_axis());
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
            *additional_closing / depth,
        ];
        let motion = shift.to_array().into_iter().chain(turn.to_array()).map(|v| v / depth);
        let Wrench { force: pull, torque: moment } = self.equilibrium.load_about_centre(&load);
        let pull = [pull, moment].map(|pull| (to_pad * pull / force).clamp_length_max(LARGEST_TANGENTIAL).to_array());
        loads.pad.extend(row.into_iter().chain(motion).chain(pull.into_iter().flatten()).map(|v| v as f32));
        loads.pressing_force.push(force);
        loads.depth.push(depth);
        loads.travel.push(travel);
        loads.motion.extend((shift * t).to_array().into_iter().chain(turn.to_array()));
    }
}
