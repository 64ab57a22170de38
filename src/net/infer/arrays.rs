//! Arrays of many predictions, for files and for Python.

use super::batch::PredictedGrasp;
use super::contact_correction::object_pose;
use super::predicted_state::{GraspState, PadState};
use crate::linear_response::GraspLoad;
use crate::network::slip_interval::FrictionMargin;
use base::error::Result;
use geometry::Pose;
use glam::DVec3;
use model::Model;
use model::sensors::SensorInput;
use rayon::prelude::*;
use record::{ErrorBound, names};

/// Calls `put` with name, shape and numbers of each available array of `answers` under `loads`, one at a time, since
/// all of them may not fit in memory. Fields are in the frame of each pad: displacement and contact force (grasps,
/// loads, pads, nodes, 3), stress (grasps, loads, pads, nodes) if the model requires it; travel (grasps, loads, pads),
/// pose of the object (grasps, loads, 7), upper ends of the prediction intervals (90 %), infinite where unknown
/// (grasps, loads), remaining fraction of the friction limit (grasps). `grasp` contains the indices of the grasps that
/// have an answer. Recordings of tactile sensors have the names used by runs, (grasps, loads, pads, ...), if the scene
/// records them.
///
/// # Errors
/// Fails if `put` fails.
pub fn each_array<E>(
    model: &Model,
    loads: &[GraspLoad],
    answers: &[Result<PredictedGrasp>],
    mut put: impl FnMut(&str, &[usize], Vec<f32>) -> std::result::Result<(), E>,
) -> std::result::Result<(), E> {
    let known = answers.iter().enumerate().filter_map(|(i, answer)| Some((i, answer.as_ref().ok()?)));
    let (numbers, known): (Vec<usize>, Vec<&PredictedGrasp>) = known.unzip();
    let (pads, topology) = (model.fingers.len(), model.fingers.first().map(|finger| &finger.topology));
    let nodes = topology.map_or(0, |pad| pad.rest.len());
    let of_loads = [known.len(), loads.len()];
    let of_pads = [known.len(), loads.len(), pads];
    let of_nodes = [known.len(), loads.len(), pads, nodes];
    let of_vectors = [known.len(), loads.len(), pads, nodes, 3];
    let flat = |v: &[DVec3]| v.iter().flat_map(|x| x.to_array()).map(|x| x as f32).collect::<Vec<_>>();
    let every = |of: &dyn Fn(&PredictedGrasp, &GraspState) -> Vec<f32>| {
        let states = known
            .iter()
            .flat_map(|answer| (0..loads.len()).filter_map(|k| Some((*answer, answer.interpolation.at(k)?))));
        states.flat_map(|(answer, state)| of(answer, &state)).collect::<Vec<_>>()
    };
    let every_pad = |of: &dyn Fn(&PadState) -> Vec<f32>| every(&|_, state| state.pads.iter().flat_map(of).collect());
    put("grasp", &[known.len()], numbers.into_iter().map(|i| i as f32).collect())?;
    put(names::FORCE, &[loads.len()], loads.iter().map(|load| (load.force * pads as f64) as f32).collect())?;
    put(names::REST, &[nodes, 3], topology.map_or_else(Vec::new, |pad| flat(&pad.rest)))?;
    put(names::DISPLACEMENT, &of_vectors, every_pad(&|pad| flat(&pad.displacement)))?;
    put(names::CONTACT_FORCE, &of_vectors, every_pad(&|pad| flat(&pad.contact)))?;
    if model.needs.stress {
        put(names::VON_MISES, &of_nodes, every_pad(&|pad| pad.stress.iter().map(|s| *s as f32).collect()))?;
    }
    put(names::TRAVEL, &of_pads, every_pad(&|pad| vec![pad.travel as f32]))?;
    let pose = |answer: &PredictedGrasp, state: &GraspState| {
        let Pose { position, rotation } = object_pose(model, &answer.first_contact, &state.pads);
        Pose { position, rotation }.row().map(|v| v as f32).to_vec()
    };
    put(names::OBJECT_POSE, &[known.len(), loads.len(), 7], every(&pose))?;
    let margins =
        |of: fn(&FrictionMargin) -> f64| known.iter().map(|answer| of(&answer.friction_margin) as f32).collect();
    put(names::SLIP_MARGIN, &[known.len()], margins(|margin| margin.expected))?;
    put(names::SLIP_MARGIN_LOW, &[known.len()], margins(|margin| margin.interval[0]))?;
    put(names::SLIP_MARGIN_HIGH, &[known.len()], margins(|margin| margin.interval[1]))?;
    for (k, name) in ErrorBound::NAMES.into_iter().enumerate() {
        put(name, &of_loads, every(&|_, state| vec![state.error.to_array()[k] as f32]))?;
    }
    let frames: Vec<(&PredictedGrasp, usize)> =
        known.iter().flat_map(|answer| (0..loads.len()).map(move |k| (*answer, k))).collect();
    for sense in model.sensors.iter() {
        let spec = sense.spec();
        let shape = [&of_loads[..], &spec.shape].concat();
        let seen = frames.par_iter().map(|(answer, k)| {
            let frame = answer.frame(model, *k).unwrap_or_default();
            sense.record(&SensorInput { fingers: &model.fingers, object: &model.object, frame: &frame }).values
        });
        put(&spec.file_name(), &shape, seen.flatten().collect())?;
    }
    Ok(())
}
