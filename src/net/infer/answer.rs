//! Answer of the network for a grasp at some loads, in SI on request.

use super::predict::PadState;
use crate::linear::object_motion::moved;
use crate::linear::pad_graph::PadGraph;
use crate::net::autodiff::tape::Matrix;
use crate::net::features::GraspFeatures;
use crate::net::features::loads::LoadFeatures;
use crate::net::network::{NetworkOutput, Normalisers};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Answer of the network for some load levels of a grasp.
#[derive(Debug)]
pub struct Answer {
    pub(crate) loads: LoadFeatures,
    pub(crate) out: NetworkOutput,
    pub(crate) norms: Normalisers,
    pub(crate) graph: Arc<PadGraph>,
    pub(crate) pads: usize,
    /// True if stress is wanted.
    pub(crate) stress: bool,
    /// Young's modulus of the gel, Pa.
    pub(crate) young: f64,
    /// Unit of force of the network, N.
    pub(crate) unit_force: f64,
    /// Travel at which the predicted faces lie on the object, m: (levels, pads).
    pub(crate) travel: Vec<f64>,
}

/// Returns the rows of one pad at one level: the `at`th `rows` rows of a matrix.
fn own(m: &Matrix, at: usize, rows: usize) -> &[f32] {
    &m.value()[at * rows * m.cols..(at + 1) * rows * m.cols]
}

fn vector(v: &[f32; 3]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

impl Answer {
    /// Returns true if all numbers of a level are finite.
    pub(crate) fn is_finite(&self, level: usize) -> bool {
        let (out, loads) = (&self.out, &self.loads);
        let (nodes, face) = (self.graph.node_count, self.graph.face.len());
        let stressed = if self.stress { nodes } else { 0 };
        (level * self.pads..(level + 1) * self.pads).all(|at| {
            let fields = [
                own(&out.displacement, at, nodes),
                own(&out.stress, at, stressed),
                own(&out.contact, at, face),
                own(&out.travel, at, 1),
                own(&out.motion, at, 1),
            ];
            // What is not finite stays so in a sum.
            let all = |v: &[f32]| v.iter().map(|v| v * 0.0).sum::<f32>() == 0.0;
            let given = [loads.depth[at], loads.travel[at], loads.pressing[at]];
            fields.into_iter().all(all) && given.iter().chain(&loads.motion[6 * at..6 * at + 6]).all(|v| v.is_finite())
        })
    }

    /// Returns the states of the pads at a mean of levels, each given with its weight.
    pub(crate) fn mixed(&self, levels: &[(usize, f64)]) -> Vec<PadState> {
        (0..self.pads).map(|pad| self.pad(pad, levels)).collect()
    }

    fn pad(&self, pad: usize, levels: &[(usize, f64)]) -> PadState {
        let Self { loads, out, norms, graph, .. } = self;
        let (t, nodes, face) = (graph.thickness, graph.node_count, graph.face.len());
        let stressed = if self.stress { nodes } else { 0 };
        let mut state = PadState {
            displacement: vec![DVec3::ZERO; nodes],
            stress: vec![0.0; stressed],
            contact: vec![DVec3::ZERO; nodes],
            travel: 0.0,
            shift: DVec3::ZERO,
            turn: DVec3::ZERO,
        };
        for &(level, weight) in levels {
            // Rows are levels, then pads.
            let at = level * self.pads + pad;
            let depth = loads.depth[at] * weight;
            let unit = depth * f64::from(norms.displacement);
            let moved = own(&out.displacement, at, nodes).as_chunks().0;
            state.displacement.iter_mut().zip(moved).for_each(|(u, v)| *u += vector(v) * unit);
            let unit = self.young * depth / t * f64::from(norms.stress);
            let stress = own(&out.stress, at, stressed);
            state.stress.iter_mut().zip(stress).for_each(|(s, v)| *s += f64::from(*v) * unit);
            let unit = loads.pressing[at] * self.unit_force * weight;
            for (i, c) in graph.face.iter().zip(own(&out.contact, at, face).as_chunks::<3>().0) {
                // Shares are of a force against the closing direction, friction in the same unit.
                state.contact[*i as usize] += vector(&[c[1], c[2], -c[0]]) * unit;
            }
            let motion = own(&out.motion, at, 1).as_chunks().0;
            let given = |k: usize| DVec3::from_slice(&loads.motion[6 * at + k..]) * weight;
            state.travel += self.travel.get(at).map_or_else(|| self.head_travel(at), |travel| *travel) * weight;
            state.shift += given(0) + vector(&motion[0]) * (depth * f64::from(norms.motion[0]));
            state.turn += given(3) + vector(&motion[1]) * (depth / t * f64::from(norms.motion[1]));
        }
        state
    }

    /// Returns the travel that the network gives for a pad at a level, m.
    fn head_travel(&self, at: usize) -> f64 {
        let [mean, scale] = self.norms.travel.map(f64::from);
        self.loads.travel[at] + self.loads.depth[at] * (mean + scale * f64::from(self.out.travel.value()[at]))
    }

    /// Moves the fingers to where the predicted faces lie on the object: the travel then agrees with field and pose.
    pub(crate) fn touch(&mut self, features: &GraspFeatures) {
        let levels = self.loads.load.len();
        let of = |level: usize| closed(features, &self.mixed(&[(level, 1.0)]));
        let travel: Vec<Vec<f64>> = (0..levels).into_par_iter().map(of).collect();
        self.travel = travel.concat();
    }
}

/// Pressing force of a node over the largest, below which it does not say where the object is.
const FAINT: f64 = 1e-2;

/// Returns the travel of each finger at which the gaps of its pressed nodes are, in the mean over their forces, those that the contact
/// law gives them.
fn closed(features: &GraspFeatures, pads: &[PadState]) -> Vec<f64> {
    let (model, graph, touch) = (&*features.model, &features.graph, &features.touch);
    let mean = |pick: fn(&PadState) -> DVec3| {
        let all = model.fingers.iter().zip(pads).map(|(f, pad)| f.placement.rotation * pick(pad));
        all.sum::<DVec3>() / pads.len() as f64
    };
    let object = match model.free {
        true => moved(model, &touch.object, mean(|p| p.shift), mean(|p| p.turn)),
        false => touch.object,
    };
    let inverse = object.rotation.inverse();
    // Sums of force times lacking gap, and of force times gap per travel.
    let sums = model.fingers.iter().zip(pads).zip(&touch.travel).map(|((finger, pad), first)| {
        let most = graph.face.iter().map(|i| -pad.contact[*i as usize].z).fold(0.0, f64::max);
        let carried = finger.placement.closing * (first + pad.travel);
        let (mut lacks, mut gains) = (0.0, 0.0);
        for ((node, x), area) in graph.face.iter().zip(&graph.rest).zip(&graph.area) {
            let force = -pad.contact[*node as usize].z;
            if force <= FAINT * most {
                continue;
            }
            let place = finger.placement.place(*x + pad.displacement[*node as usize]) + carried;
            let at = inverse * (place - object.position);
            let Some(closest) = model.object.distance.closest(at, f64::INFINITY) else { continue };
            let wanted = (model.law.offset - force / area / model.law.stiffness).max(model.law.least());
            lacks += force * (wanted - closest.distance);
            gains += force * (object.rotation * closest.normal).dot(finger.placement.closing);
        }
        (lacks, gains)
    });
    let sums: Vec<(f64, f64)> = sums.collect();
    let far = FARTHEST * features.graph.thickness;
    let by = |(lacks, gains): (f64, f64)| if gains < 0.0 { (lacks / gains).clamp(-far, far) } else { 0.0 };
    // Geared fingers go together.
    let both = sums.iter().fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let own = sums.iter().map(|own| by(if model.geared() { both } else { *own }));
    pads.iter().zip(own).map(|(pad, by)| pad.travel + by).collect()
}

/// Largest correction of the travel, over the thickness: a field that asks for more is not one to go by.
const FARTHEST: f64 = 0.3;
