//! Errors of a trained model on grasps that it has not seen.

pub mod dump;
pub mod frames;
pub mod picture;
pub mod rank;
pub mod table;

use super::infer::predict::{PadState, Predictor};
use super::train::data;
use super::train::sample::Sample;
use crate::dataset::DataSet;
use crate::error::Result;
use crate::interrupt;
use crate::linear::pad_graph::mesh_hash;
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use std::time::Instant;

/// Errors of one frame of one grasp, over both pads. Relative errors are relative to the field's L2 norm in that frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FrameError {
    /// Name of the object.
    pub object: String,
    /// Number of the grasp.
    pub grasp: usize,
    /// Number of the frame.
    pub frame: usize,
    /// Force per finger, N.
    pub force_n: f64,
    /// Force over that of the last frame.
    pub load: f64,
    /// Displacement, relative.
    pub displacement: f64,
    /// Displacement, root mean square over the nodes, mm.
    pub displacement_mm: f64,
    /// Displacement, largest of a node, mm.
    pub displacement_worst_mm: f64,
    /// Von Mises stress, relative.
    pub stress: f64,
    /// Von Mises stress, root mean square over the nodes, kPa.
    pub stress_kpa: f64,
    /// Nodal contact force, relative.
    pub contact_force: f64,
    /// Travel, mean over the fingers, relative.
    pub travel: f64,
    /// Travel, mean over the fingers, mm.
    pub travel_mm: f64,
    /// Translation of the object, mm.
    pub object_mm: f64,
    /// Rotation of the object, degrees.
    pub object_deg: f64,
}

/// Quantities of the last frame by which grasps are ranked.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Peak {
    /// Largest nodal stress, Pa.
    pub stress: f64,
    /// Largest nodal displacement, m.
    pub displacement: f64,
}

/// Judgement of a grasp.
#[derive(Debug, Clone)]
pub struct Judged {
    /// Errors, one entry per frame.
    pub frames: Vec<FrameError>,
    /// Truth and prediction at the last frame.
    pub peaks: [Peak; 2],
    /// Time of the network: the pass per grasp, and all load levels, s.
    pub time_s: [f64; 2],
}

/// Judges `predictor` on the test grasps of `split`.
///
/// # Errors
/// Fails if data cannot be read, or lies outside the range that the model was trained on.
pub fn judge(set: &DataSet, predictor: &Predictor, split: &str) -> Result<Vec<Judged>> {
    let samples = test_grasps(set, predictor, split)?;
    samples.par_iter().map(|sample| interrupt::check().and_then(|()| judge_grasp(predictor, sample))).collect()
}

/// Reads the test grasps of `split`.
///
/// # Errors
/// Fails as [`judge`] does.
pub fn test_grasps(set: &DataSet, predictor: &Predictor, split: &str) -> Result<Vec<Sample>> {
    let sets = data::split(&set.splits, split)?;
    for object in &set.objects {
        predictor.card.range.admits_pad(&object.pad, &mesh_hash(&object.pad))?;
    }
    let (samples, range) = data::read(set, &sets.test, predictor.network.layout(), usize::MAX)?;
    let mut trained = predictor.card.range.clone();
    // Another pad, law or kind of object is refused; the errors are for the numbers as they are.
    trained.extend(&range)?;
    Ok(samples)
}

fn judge_grasp(predictor: &Predictor, sample: &Sample) -> Result<Judged> {
    let clock = Instant::now();
    let seen = predictor.encode(sample.features.clone());
    let encode = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    let states = predictor.ramp(&seen, &sample.given)?;
    let time_s = [encode, clock.elapsed().as_secs_f64()];
    let frames: Vec<FrameError> = states.iter().enumerate().map(|(k, s)| frame_error(sample, k, s)).collect();
    let truth = |k: usize| {
        let (u, s) = truth(sample, k);
        peak(u.iter(), s.iter())
    };
    let last = states.len() - 1;
    let own = &states[last];
    let predicted = peak(own.iter().flat_map(|p| &p.displacement), own.iter().flat_map(|p| &p.stress));
    Ok(Judged { frames, peaks: [truth(last), predicted], time_s })
}

fn peak<'a>(u: impl Iterator<Item = &'a DVec3>, s: impl Iterator<Item = &'a f64>) -> Peak {
    Peak { stress: s.copied().fold(0.0, f64::max), displacement: u.map(|u| u.length()).fold(0.0, f64::max) }
}

/// Returns displacement and stress that FEM found, all pads, level `k`.
fn truth(sample: &Sample, k: usize) -> (Vec<DVec3>, Vec<f64>) {
    let n = sample.stress.len() / sample.forces.len();
    let vectors = sample.displacement[3 * k * n..3 * (k + 1) * n].as_chunks::<3>().0;
    let u = vectors.iter().map(|v| DVec3::from_array(v.map(f64::from))).collect();
    (u, sample.stress[k * n..(k + 1) * n].iter().map(|v| f64::from(*v)).collect())
}

fn frame_error(sample: &Sample, k: usize, states: &[PadState]) -> FrameError {
    let (u, s) = truth(sample, k);
    let pads = states.len();
    let own_u = states.iter().flat_map(|p| &p.displacement);
    let own_s = states.iter().flat_map(|p| &p.stress);
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
    let ec = norm(&mut contact.iter().zip(own).map(|(a, b)| a.distance(b)));
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
        contact_force: relative(ec, norm(&mut contact.iter().map(|v| v.length()))),
        travel: relative(et, mean),
        travel_mm: et * 1e3,
        object_mm: of(|s| s.shift, 0) * 1e3,
        object_deg: of(|s| s.turn, 3).to_degrees(),
    }
}
