//! Truth and prediction of a grasp of a data set, as frames in hand axes.

use crate::infer::contact_correction::object_pose;
use crate::infer::predict::{PadState, Predictor};
use crate::linear_response::{GraspLoad, frame_loads};
use base::error::Result;
use dataset::inspect::frame;
use dataset::{ObjectFile, StoredGrasp};
use geometry::Pose;
use geometry::Wrench;
use glam::DVec3;
use model::Model;
use record::{Frame, PadFrame};
use std::sync::Arc;

/// Returns the frames `wanted` of `grasp` as simulated by finite elements, and as predicted by `predictor` from first
/// contact; `model` is that of `file`.
///
/// # Errors
/// Fails if first contact cannot be found, or if predicted numbers are not finite.
pub fn reference_and_prediction(
    file: &ObjectFile,
    model: &Arc<Model>,
    predictor: &Predictor,
    grasp: &StoredGrasp,
    wanted: &[usize],
) -> Result<[Vec<Frame>; 2]> {
    let pads = predictor.canonical_pads(model)?;
    let touch = pads.first_contact(Pose::from_row(&grasp.grasp_pose))?;
    let encoded = predictor.encode_first_contact(&pads, &touch);
    let all = frame_loads(model);
    let applied = |k: &usize| GraspLoad { force: grasp.force[*k] / file.sizes.pads as f64, ..all[*k] };
    let states = predictor.states(&encoded, &wanted.iter().map(applied).collect::<Vec<_>>())?;
    let truth: Vec<Frame> = wanted.iter().map(|k| frame(file, grasp, *k)).collect();
    let predicted = truth
        .iter()
        .zip(&states)
        .map(|(truth, states)| predicted(file, truth, grasp, &states.pads, object_pose(model, &touch, &states.pads)));
    let predicted = predicted.collect();
    Ok([truth, predicted])
}

/// Returns the prediction as a frame in hand axes.
fn predicted(file: &ObjectFile, truth: &Frame, grasp: &StoredGrasp, states: &[PadState], object: Pose) -> Frame {
    let pads = file.sizes.pads;
    let pad = |(i, state): (usize, &PadState)| {
        let (pose, at) = (&file.pad_poses[i], truth.index * pads + i);
        let touch = grasp.finger_position[at] - grasp.travel[at];
        let carried = pose.position + file.closing[i] * (touch + state.travel);
        let displacement: Vec<DVec3> = state.displacement.iter().map(|u| pose.rotation * *u).collect();
        PadFrame {
            position: file.pads[i]
                .rest
                .iter()
                .zip(&displacement)
                .map(|(x, u)| pose.rotation * *x + carried + *u)
                .collect(),
            displacement,
            contact_force: state.contact.iter().map(|f| pose.rotation * *f).collect(),
            von_mises_node: state.stress.clone(),
            wrench: Wrench::default(),
            ..PadFrame::default()
        }
    };
    Frame {
        index: truth.index,
        applied_force: truth.applied_force,
        travel: states.iter().map(|s| s.travel).collect(),
        object_position: object.position,
        object_rotation: object.rotation,
        pads: states.iter().enumerate().map(pad).collect(),
        ..Frame::default()
    }
}
