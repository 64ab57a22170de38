//! Errors of a trained model on test grasps.

pub mod acceptance;
pub mod dump;
pub mod frames;
pub mod picture;
pub mod rank_correlation;
pub mod slip;
pub mod table;

use super::infer::predict::Predictor;
use super::train::data;
pub use super::train::frame_error::FrameError;
use super::train::frame_error::{frame_error, labelled, reference_fields};
use super::train::sample::{LabelNodes, Sample};
use base::error::Result;
use base::interrupt;
use dataset::DataSet;
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use std::time::Instant;

/// Quantities of the last frame by which grasps are ranked.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Peak {
    /// Largest nodal stress, Pa.
    pub stress: f64,
    /// Largest nodal displacement, m.
    pub displacement: f64,
}

/// Evaluation of one grasp.
#[derive(Debug, Clone)]
pub struct GraspEvaluation {
    /// Errors, one entry per frame.
    pub frames: Vec<FrameError>,
    /// Truth and prediction at the last frame.
    pub peaks: [Peak; 2],
    /// Time of the network, s: for the pass per grasp, and for all load levels.
    pub time_s: [f64; 2],
}

/// Evaluates `predictor` on the test grasps of `split`.
///
/// # Errors
/// Fails if data cannot be read or, without `extrapolate`, if pad or gel law is outside the range of the training.
pub fn evaluate(set: &DataSet, predictor: &Predictor, split: &str, extrapolate: bool) -> Result<Vec<GraspEvaluation>> {
    let samples = test_grasps(set, predictor, split, extrapolate)?;
    samples.par_iter().map(|sample| interrupt::check().and_then(|()| evaluate_grasp(predictor, sample))).collect()
}

/// Reads the test grasps of `split` that reached their load; none if all of them were dropped.
///
/// # Errors
/// Fails in the cases of [`evaluate`].
pub fn test_grasps(set: &DataSet, predictor: &Predictor, split: &str, extrapolate: bool) -> Result<Vec<Sample>> {
    let poses = data::split(&[&set.splits], split)?.remove(0).test;
    if !extrapolate {
        for object in &set.objects {
            object.require_equal_pads("a network")?;
            predictor.card.range.check_pad(&object.pads[0])?;
        }
    }
    if set.select(&poses).is_empty() && !set.select_dropped(&poses).is_empty() {
        return Ok(Vec::new());
    }
    let (samples, range) = data::read(&[(set, &poses)], &predictor.pads, LabelNodes::Scene, usize::MAX)?;
    if !extrapolate {
        // Refuses another gel law; other quantities may lie outside the range.
        predictor.card.range.clone().extend(&range)?;
    }
    Ok(samples)
}

fn evaluate_grasp(predictor: &Predictor, sample: &Sample) -> Result<GraspEvaluation> {
    let clock = Instant::now();
    let encoded = predictor.encode(sample.features.clone());
    let encode = clock.elapsed().as_secs_f64();
    let clock = Instant::now();
    let states = predictor.states(&encoded, &sample.grasp_loads)?;
    let time_s = [encode, clock.elapsed().as_secs_f64()];
    let frames: Vec<FrameError> = states.iter().enumerate().map(|(k, s)| frame_error(sample, k, s)).collect();
    let truth = |k: usize| {
        let (u, s) = reference_fields(sample, k);
        peak(u.iter(), s.iter())
    };
    let last = states.len() - 1;
    let own = labelled(sample, &states[last]);
    let predicted = peak(own.pads.iter().flat_map(|p| &p.displacement), own.pads.iter().flat_map(|p| &p.stress));
    Ok(GraspEvaluation { frames, peaks: [truth(last), predicted], time_s })
}

fn peak<'a>(u: impl Iterator<Item = &'a DVec3>, s: impl Iterator<Item = &'a f64>) -> Peak {
    Peak { stress: s.copied().fold(0.0, f64::max), displacement: u.map(|u| u.length()).fold(0.0, f64::max) }
}
