//! Errors of a prediction against a data set.

use super::sample::Sample;
use crate::infer::predict::{GraspState, PadState};
use glam::DVec3;
use record::ErrorBound;
use serde::Serialize;
use std::borrow::Cow;

/// Errors of one frame of one grasp, over all pads. Relative errors are relative to the field's L2 norm in that frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameError {
    /// Name of the object.
    pub object: String,
    /// Index of the grasp.
    pub grasp: usize,
    /// Index of the frame.
    pub frame: usize,
    /// Force per finger, N.
    pub force_n: f64,
    /// Force over that of the last frame.
    pub load: f64,
    /// Displacement, relative.
    pub displacement: f64,
    /// Displacement, root mean square over the nodes, mm.
    pub displacement_mm: f64,
    /// Displacement, largest over the nodes, mm.
    pub displacement_worst_mm: f64,
    /// Von Mises stress, relative.
    pub stress: f64,
    /// Von Mises stress, root mean square over the nodes, kPa.
    pub stress_kpa: f64,
    /// Nodal contact force, relative.
    pub contact_force: f64,
    /// Contact force gathered at the corner nodes of the elements, relative.
    pub traction: f64,
    /// Travel, mean over the fingers, relative.
    pub travel: f64,
    /// Travel, mean over the fingers, mm.
    pub travel_mm: f64,
    /// Translation of the object, mm.
    pub object_mm: f64,
    /// Rotation of the object, degrees.
    pub object_deg: f64,
    /// Prediction interval of the network.
    pub bound: ErrorBound,
}

/// Returns displacement and stress simulated by finite elements, of all pads, at level `k`.
pub(crate) fn reference_fields(sample: &Sample, k: usize) -> (Vec<DVec3>, Vec<f64>) {
    let n = sample.stress.len() / sample.forces.len();
    let vectors = sample.displacement[3 * k * n..3 * (k + 1) * n].as_chunks::<3>().0;
    let u = vectors.iter().map(|v| DVec3::from_array(v.map(f64::from))).collect();
    (u, sample.stress[k * n..(k + 1) * n].iter().map(|v| f64::from(*v)).collect())
}

/// Returns the state at the nodes of the labels of `sample`, from that at the canonical nodes.
pub(crate) fn labelled<'a>(sample: &Sample, state: &'a GraspState) -> Cow<'a, GraspState> {
    match &sample.to_labels {
        Some(map) => Cow::Owned(state.transferred(map)),
        None => Cow::Borrowed(state),
    }
}

/// Computes the errors of a prediction at level `k` of a sample.
pub(crate) fn frame_error(sample: &Sample, k: usize, state: &GraspState) -> FrameError {
    let states = &state.pads;
    let (u, s) = reference_fields(sample, k);
    let pads = states.len();
    let labelled = labelled(sample, state);
    let own_u = labelled.pads.iter().flat_map(|p| &p.displacement);
    let own_s = labelled.pads.iter().flat_map(|p| &p.stress);
    let du: Vec<f64> = u.iter().zip(own_u).map(|(a, b)| a.distance(*b)).collect();
    let ds: Vec<f64> = s.iter().zip(own_s).map(|(a, b)| a - b).collect();
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    let relative = |error: f64, whole: f64| if whole > 0.0 { error / whole } else { 0.0 };
    let count = (u.len() as f64).sqrt();
    let (eu, es) = (norm(&mut du.iter().copied()), norm(&mut ds.iter().copied()));
    let face = &sample.features.graph.face;
    let contact = &sample.contact[3 * k * pads * face.len()..3 * (k + 1) * pads * face.len()];
    let contact: Vec<DVec3> = contact.as_chunks::<3>().0.iter().map(|v| DVec3::from_array(v.map(f64::from))).collect();
    let own = states.iter().flat_map(|p| face.iter().map(|i| p.contact[*i as usize]));
    let off: Vec<DVec3> = own.zip(&contact).map(|(own, contact)| own - contact).collect();
    let length = |forces: &[DVec3]| norm(&mut forces.iter().map(|f| f.length()));
    let gathered = |forces: &[DVec3]| {
        let corners = forces.chunks_exact(face.len()).flat_map(|pad| sample.features.graph.basis.corner_forces(pad));
        length(&corners.collect::<Vec<_>>())
    };
    let travel = &sample.travel[k * pads..(k + 1) * pads];
    let et = travel.iter().zip(states).map(|(a, b)| (a - b.travel).abs()).sum::<f64>() / pads as f64;
    let mean = travel.iter().sum::<f64>() / pads as f64;
    let motion = &sample.motion[6 * k * pads..6 * (k + 1) * pads];
    let of = |pick: fn(&PadState) -> DVec3, at: usize| {
        let errors = states.iter().enumerate().map(|(p, s)| pick(s).distance(DVec3::from_slice(&motion[6 * p + at..])));
        errors.sum::<f64>() / pads as f64
    };
    FrameError {
        object: sample.object.clone(),
        grasp: sample.grasp,
        frame: sample.frames[k],
        force_n: sample.forces[k],
        load: sample.forces[k] / sample.forces[sample.forces.len() - 1],
        displacement: relative(eu, norm(&mut u.iter().map(|v| v.length()))),
        displacement_mm: eu / count * 1e3,
        displacement_worst_mm: du.iter().copied().fold(0.0, f64::max) * 1e3,
        stress: relative(es, norm(&mut s.iter().copied())),
        stress_kpa: es / count * 1e-3,
        contact_force: relative(length(&off), length(&contact)),
        traction: relative(gathered(&off), gathered(&contact)),
        travel: relative(et, mean),
        travel_mm: et * 1e3,
        object_mm: of(|s| s.translation, 0) * 1e3,
        object_deg: of(|s| s.rotation_vector, 3).to_degrees(),
        bound: labelled.error,
    }
}
