//! What the network sees of a load: the springs at rest under it, and the contact forces that the gel makes of them.

use super::features::Features;
use super::features::Parity::{self, Even, X, XY, Y};
use super::sample::rows;
use super::settle::{LANES, Touching, settle};
use super::springs::{Rest, Spring};
use glam::DVec3;
use rayon::prelude::*;

/// Features of a node at a load. From its spring: pressed over depth (negative is a gap), pressed, share of the force, the
/// spring's displacement over depth. From the settled gel: share of the force, how much of that acts along the
/// face, and the linear response over depth.
pub const NODE_LOAD: [Parity; 12] = [Even, Even, Even, X, Y, Even, Even, X, Y, X, Y, Even];
/// Features of a pad at a load: logarithm and cube root of the force, depth, touching area, centre of pressure, pull along
/// the face and twist over the force, travel over depth, what settling adds to it, motion of the object over depth.
pub const PAD_LOAD: [Parity; 17] = [Even, Even, Even, Even, X, Y, X, Y, XY, Even, Even, X, Y, Even, Y, X, XY];

/// Share of the force below which a node hardly touches.
const FAINT: f64 = 1e-3;

/// What the network sees of some load levels of a grasp; levels one after the other, then pads, then nodes.
#[derive(Debug, Clone, Default)]
pub struct Loads {
    /// (levels * pads * face nodes, [`NODE_LOAD`]).
    pub node: Vec<f32>,
    /// (levels * pads, [`PAD_LOAD`]).
    pub pad: Vec<f32>,
    /// Force per finger over `E t^2`: (levels).
    pub force: Vec<f64>,
    /// What each pad presses with over `E t^2`: (levels * pads).
    pub pressing: Vec<f64>,
    /// Displacement of the springs that carry the force, m: (levels * pads).
    pub depth: Vec<f64>,
    /// Travel that the springs allow, m: (levels * pads).
    pub travel: Vec<f64>,
    /// Motion of the object on the springs, m and rad, axes of each pad: (levels * pads, 6).
    pub motion: Vec<f64>,
}

impl Loads {
    /// Those of the levels that `wanted` numbers.
    pub fn levels(&self, wanted: &[usize]) -> Self {
        let count = self.force.len();
        Self {
            node: rows(&self.node, count, wanted),
            pad: rows(&self.pad, count, wanted),
            force: rows(&self.force, count, wanted),
            pressing: rows(&self.pressing, count, wanted),
            depth: rows(&self.depth, count, wanted),
            travel: rows(&self.travel, count, wanted),
            motion: rows(&self.motion, count, wanted),
        }
    }

    /// What presses over `E t^2` over depth over thickness: (levels * pads).
    pub fn scale(&self, features: &Features) -> Vec<f32> {
        let t = features.graph.thickness;
        self.pressing.iter().zip(&self.depth).map(|(force, depth)| (force * t / depth) as f32).collect()
    }
}

/// A pad whose gel has settled under a load.
struct Settled {
    /// Force on each face node.
    force: Vec<DVec3>,
    /// How much farther than the springs the pad must be closed.
    closer: f64,
    /// Linear response of each face node.
    given: Vec<DVec3>,
}

impl Features {
    /// The features at loads given as force per finger, N.
    pub fn loads(&self, forces: &[f64]) -> Loads {
        let t = self.graph.thickness;
        let mut loads = Loads::default();
        for some in forces.chunks(LANES) {
            let some: Vec<f64> = some.iter().map(|force| force / self.unit_force()).collect();
            let rests: Vec<Rest> = some.par_iter().map(|force| self.bed.rest(*force)).collect();
            let settled: Vec<Vec<Settled>> = (0..self.pads).into_par_iter().map(|p| self.settled(p, &rests)).collect();
            for (k, (force, rest)) in some.iter().zip(&rests).enumerate() {
                loads.force.push(*force);
                (0..self.pads).for_each(|p| self.load_pad(p, rest, &settled[p][k], &mut loads));
            }
        }
        loads.depth.iter_mut().chain(&mut loads.travel).for_each(|d| *d *= t);
        loads
    }

    /// What the gel of pad `p` makes of the springs, over the thickness and `E t^2`.
    fn settled(&self, p: usize, rests: &[Rest]) -> Vec<Settled> {
        let (n, to_pad) = (self.graph.face.len(), self.to_pad[p]);
        let springs = &self.bed.springs()[p * n..(p + 1) * n];
        let touching = |rest: &Rest| -> Vec<Touching> {
            let (pressed, dragged) = (&rest.pressed[p * n..], |i: usize| rest.dragged(p * n + i));
            let of = |(i, s): (usize, &Spring)| Touching {
                node: self.graph.face[i] as usize,
                normal: to_pad * s.normal,
                pressed: pressed[i],
                dragged: to_pad * dragged(i),
                force: to_pad * (s.normal * self.bed.pressure(s, pressed[i]) + self.bed.drag(s, dragged(i))),
            };
            springs.iter().enumerate().map(of).collect()
        };
        let touching: Vec<Vec<Touching>> = rests.iter().map(touching).collect();
        let Some(compliance) = &self.graph.compliance else {
            let plain = |load: &Vec<Touching>| load.iter().map(|t| t.force).collect();
            return touching
                .iter()
                .map(|load| Settled { force: plain(load), closer: 0.0, given: vec![DVec3::ZERO; n] })
                .collect();
        };
        let (force, closer): (Vec<Vec<DVec3>>, Vec<f64>) = settle(compliance, &touching).into_iter().unzip();
        let given = compliance.on_face(&self.graph.face, &force);
        let parts = force.into_iter().zip(closer).zip(given);
        parts.map(|((force, closer), given)| Settled { force, closer, given }).collect()
    }

    /// Adds pad `p` under the last force, all over the thickness and `E t^2`.
    fn load_pad(&self, p: usize, rest: &Rest, gel: &Settled, loads: &mut Loads) {
        let (n, to_pad) = (self.graph.face.len(), self.to_pad[p]);
        let force = self.bed.carried_by(p, loads.force[loads.force.len() - 1]);
        let own = p * n..(p + 1) * n;
        let springs = &self.bed.springs()[own.clone()];
        let pressed = &rest.pressed[own.clone()];
        let dragged: Vec<DVec3> = own.map(|i| rest.dragged(i)).collect();
        let carried: Vec<f64> = springs.iter().zip(pressed).map(|(s, d)| self.bed.pressure(s, *d)).collect();
        let whole = carried.iter().sum::<f64>().max(1e-12);
        // How each spring gives: along the normal where it is pressed, along the face where it is dragged.
        let give = |i: usize| springs[i].normal * pressed[i].max(0.0) + dragged[i];
        let depth = (0..n).map(|i| carried[i] / whole * give(i).length()).sum::<f64>().max(1e-9);
        let Settled { force: settled, closer, given } = gel;
        let (mut center, mut area, mut pull, mut twist) = (DVec3::ZERO, 0.0, DVec3::ZERO, 0.0);
        for (i, s) in springs.iter().enumerate() {
            let at = self.graph.rest[i] / self.graph.thickness;
            let drag = to_pad * self.bed.drag(s, dragged[i]);
            let push = settled[i];
            // Next to nothing where next to nothing presses: the edge of the contact is not sharp.
            let sideways = push / (-push.z.min(0.0) + FAINT * force);
            let [x, y, z] = (to_pad * give(i) / depth).to_array();
            center += at * (carried[i] / whole);
            area += if pressed[i] > 0.0 { s.area } else { 0.0 };
            pull += drag / force;
            twist += (at.x * drag.y - at.y * drag.x) / force;
            let into = pressed[i].max(0.0);
            let row = [(pressed[i] / depth).max(-4.0), into, carried[i] / whole, x, y, z];
            let share = [-push.z.min(0.0) / force, sideways.x, sideways.y];
            let given = given[i].to_array().map(|u| u / depth);
            loads.node.extend(row.into_iter().chain(share).chain(given).map(|v| v as f32));
        }
        let travel = rest.travel[p];
        let (shift, turn) = (to_pad * rest.shift, to_pad * rest.turn);
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
        let motion = shift.to_array().into_iter().chain(turn.to_array());
        loads.pad.extend(row.into_iter().chain(motion.map(|v| v / depth)).map(|v| v as f32));
        loads.pressing.push(force);
        loads.depth.push(depth);
        loads.travel.push(travel);
        loads.motion.extend((shift * self.graph.thickness).to_array().into_iter().chain(turn.to_array()));
    }
}
