//! Output of the network for a grasp at some loads, converted to SI on request.

use super::contact_correction::{UncorrectedAnswer, corrected_travel};
pub use super::output_arrays::OutputArrays;
use super::predicted_state::{GraspState, PadState};
use super::response::RequiredFields;
use crate::features::GraspFeatures;
use crate::features::loads::{CONTACT_AREA, LoadFeatures, NODE_LOAD, PAD_LOAD, PROJECTED_FRACTION};
use crate::linear_response::pad_graph::PadGraph;
use crate::network::Normalisers;
use crate::network::interval::{ErrorIndicators, PredictionInterval};
use glam::DVec3;
use rayon::prelude::*;
use record::{ErrorBound, FieldTransfer};
use std::sync::Arc;

/// Output of the network for some load levels of a grasp.
#[derive(Debug)]
pub struct GraspOutput {
    pub(crate) loads: LoadFeatures,
    pub(crate) out: OutputArrays,
    pub(crate) norms: Normalisers,
    pub(crate) graph: Arc<PadGraph>,
    /// Map of the fields to the mesh of the scene; None if it is the canonical one.
    pub(crate) to_scene: Option<Arc<FieldTransfer>>,
    pub(crate) pads: usize,
    pub(crate) fields: RequiredFields,
    /// Young's modulus of the gel, Pa.
    pub(crate) young: f64,
    /// Unit of force of the network, N.
    pub(crate) unit_force: f64,
    /// Travel at which the predicted faces touch the object, m: (levels, pads).
    pub(crate) travel: Vec<f64>,
    /// Error indicators of each level.
    pub(crate) error_indicators: Vec<ErrorIndicators>,
    pub(crate) interval: Option<PredictionInterval>,
    /// Flags: the prediction interval is valid at a level.
    pub(crate) interval_valid: Vec<bool>,
}

/// Returns block `at` of `count` numbers: those of one pad at one level.
fn block(all: &[f32], at: usize, count: usize) -> &[f32] {
    &all[at * count..(at + 1) * count]
}

fn vector(v: &[f32; 3]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

impl GraspOutput {
    /// Returns true if all numbers of a level are finite.
    pub(crate) fn is_finite(&self, level: usize) -> bool {
        let (out, loads) = (&self.out, &self.loads);
        let (nodes, face) = (self.graph.node_count, self.graph.face.len());
        let stressed = if self.fields.stress { nodes } else { 0 };
        (level * self.pads..(level + 1) * self.pads).all(|at| {
            let fields = [
                block(&out.displacement, at, 3 * nodes),
                block(&out.stress, at, stressed),
                block(&out.contact, at, 3 * face),
                block(&out.travel, at, 1),
                block(&out.motion, at, 6),
            ];
            // `v * 0.0` is NaN for every `v` that is not finite, and a sum preserves NaN.
            let all = |v: &[f32]| v.iter().map(|v| v * 0.0).sum::<f32>() == 0.0;
            let given = [loads.depth[at], loads.travel[at], loads.pressing_force[at]];
            fields.into_iter().all(all) && given.iter().chain(&loads.motion[6 * at..6 * at + 6]).all(|v| v.is_finite())
        })
    }

    /// Returns the state at one level, on the mesh of the scene.
    pub(crate) fn at(&self, level: usize) -> GraspState {
        linear_combination(&[(self, level, 1.0)])
    }

    /// Returns the states of the pads at one level, on the canonical mesh.
    fn canonical_pads(&self, level: usize) -> Vec<PadState> {
        (0..self.pads).map(|pad| combined_pad(pad, &[(self, level, 1.0)])).collect()
    }

    /// Returns the upper ends of the prediction intervals (90 %) of a level.
    pub(crate) fn error(&self, level: usize) -> ErrorBound {
        let known = self.interval.zip(self.error_indicators.get(level)).filter(|_| self.interval_valid[level]);
        known.map_or(ErrorBound::UNKNOWN, |(interval, signs)| interval.at(signs))
    }

    /// Returns the displacement of the face nodes of all pads at a level, m.
    pub(crate) fn face_displacement(&self, level: usize) -> impl ExactSizeIterator<Item = DVec3> {
        let (graph, nodes) = (&self.graph, self.graph.node_count);
        let count = graph.face.len();
        (0..self.pads * count).map(move |i| {
            let at = level * self.pads + i / count;
            let moved = block(&self.out.displacement, at, 3 * nodes).as_chunks().0;
            vector(&moved[graph.face[i % count] as usize]) * (self.loads.depth[at] * f64::from(self.norms.displacement))
        })
    }

    /// Returns the travel output of the network, m; `at` is the index of pad and level.
    fn network_travel(&self, at: usize) -> f64 {
        let [mean, scale] = self.norms.travel.map(f64::from);
        self.loads.travel[at] + self.loads.depth[at] * (mean + scale * f64::from(self.out.travel[at]))
    }

    /// Returns the fraction of the pressing force that the network moved from the nodes of the projected contact to
    /// others, mean over the pads.
    fn moved_force(&self, level: usize) -> f64 {
        let face = self.graph.face.len();
        let of = |pad: usize| {
            let at = level * self.pads + pad;
            let projected = block(&self.loads.node, at, NODE_LOAD.len() * face).chunks_exact(NODE_LOAD.len());
            let own = block(&self.out.contact, at, 3 * face).as_chunks::<3>().0;
            own.iter().zip(projected).map(|(own, row)| f64::from((own[0] - row[PROJECTED_FRACTION]).abs())).sum::<f64>()
        };
        0.5 * (0..self.pads).map(of).sum::<f64>() / self.pads as f64
    }

    /// Returns the effective contact area over the square of the thickness, mean over the pads.
    fn contact_area(&self, level: usize) -> f64 {
        let of = |pad: usize| f64::from(block(&self.loads.pad, level * self.pads + pad, PAD_LOAD.len())[CONTACT_AREA]);
        (0..self.pads).map(of).sum::<f64>() / self.pads as f64
    }

    /// Moves the fingers to where the predicted faces touch the object, so that the travel is consistent with
    /// displacement field and pose. The remaining mismatch is an error indicator.
    pub(crate) fn correct_travel(&mut self, features: &GraspFeatures) {
        let levels = self.loads.load.len();
        let of = |level: usize| {
            let pads = self.canonical_pads(level);
            let depth =
                self.loads.depth[level * self.pads..(level + 1) * self.pads].iter().sum::<f64>() / self.pads as f64;
            let (moved_force, area) = (self.moved_force(level), self.contact_area(level));
            let load = &self.loads.load[level];
            corrected_travel(features, &UncorrectedAnswer { pads: &pads, load, depth, moved_force, area })
        };
        let corrected: Vec<(Vec<f64>, ErrorIndicators)> = (0..levels).into_par_iter().map(of).collect();
        self.travel = corrected.iter().flat_map(|(travel, _)| travel).copied().collect();
        self.error_indicators = corrected.into_iter().map(|(_, signs)| signs).collect();
    }
}

/// Returns the linear combination of decoded states, each given by its answer, level and weight, on the mesh of the
/// scene; its error is the largest of theirs.
pub(crate) fn linear_combination(parts: &[(&GraspOutput, usize, f64)]) -> GraspState {
    let pads = parts.first().map_or(0, |(answer, ..)| answer.pads);
    let errors = parts.iter().map(|(answer, level, _)| answer.error(*level));
    let error = errors.reduce(|a, b| a.or_larger(&b)).unwrap_or(ErrorBound::UNKNOWN);
    let held = parts.iter().all(|(answer, level, _)| answer.loads.held[*level]);
    let to_scene = parts.first().and_then(|(answer, ..)| answer.to_scene.as_deref());
    let state = GraspState { pads: (0..pads).map(|pad| combined_pad(pad, parts)).collect(), held, error };
    match to_scene {
        Some(map) => state.transferred(map),
        None => state,
    }
}

fn combined_pad(pad: usize, parts: &[(&GraspOutput, usize, f64)]) -> PadState {
    let (nodes, stressed) = parts.first().map_or((0, 0), |(answer, ..)| {
        (answer.graph.node_count, if answer.fields.stress { answer.graph.node_count } else { 0 })
    });
    let mut state = PadState {
        displacement: vec![DVec3::ZERO; nodes],
        stress: vec![0.0; stressed],
        contact: vec![DVec3::ZERO; nodes],
        travel: 0.0,
        translation: DVec3::ZERO,
        rotation_vector: DVec3::ZERO,
    };
    for &(answer, level, weight) in parts {
        let GraspOutput { loads, out, norms, graph, .. } = answer;
        let (t, face) = (graph.thickness, graph.face.len());
        // Rows are ordered by level, then pad.
        let at = level * answer.pads + pad;
        let depth = loads.depth[at] * weight;
        let unit = depth * f64::from(norms.displacement);
        let moved = block(&out.displacement, at, 3 * nodes).as_chunks().0;
        if answer.fields.interior {
            state.displacement.iter_mut().zip(moved).for_each(|(u, v)| *u += vector(v) * unit);
        } else {
            graph.face.iter().for_each(|i| state.displacement[*i as usize] += vector(&moved[*i as usize]) * unit);
        }
        let unit = answer.young * depth / t * f64::from(norms.stress);
        let stress = block(&out.stress, at, stressed);
        state.stress.iter_mut().zip(stress).for_each(|(s, v)| *s += f64::from(*v) * unit);
        let unit = loads.pressing_force[at] * answer.unit_force * weight;
        for (i, c) in graph.face.iter().zip(block(&out.contact, at, 3 * face).as_chunks::<3>().0) {
            // In units of the pressing force: normal component against the closing direction, friction along x and y.
            state.contact[*i as usize] += vector(&[c[1], c[2], -c[0]]) * unit;
        }
        state.travel += answer.travel.get(at).map_or_else(|| answer.network_travel(at), |travel| *travel) * weight;
        // A supported object does not move.
        if loads.held[level] {
            continue;
        }
        let motion = block(&out.motion, at, 6).as_chunks().0;
        let given = |k: usize| DVec3::from_slice(&loads.motion[6 * at + k..]) * weight;
        state.translation += given(0) + vector(&motion[0]) * (depth * f64::from(norms.motion[0]));
        state.rotation_vector += given(3) + vector(&motion[1]) * (depth / t * f64::from(norms.motion[1]));
    }
    // Interpolation may overshoot.
    state.stress.iter_mut().for_each(|s| *s = s.max(0.0));
    state
}
