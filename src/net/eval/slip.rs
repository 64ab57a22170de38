//! Loads at which objects slip: predicted, and by finite elements.

use crate::infer::predict::Predictor;
use crate::network::slip_interval::FrictionMargin;
use crate::train::data;
use crate::train::slipped;
use base::error::Result;
use dataset::DataSet;
use rayon::prelude::*;
use serde::Serialize;

/// Error of the load at which an object slips that counts as close.
const CLOSE: f64 = 0.1;

/// Slip loads of the test grasps that finite elements dropped under a push.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SlipEvaluation {
    /// Number of grasps.
    pub grasps: usize,
    /// Fraction whose predicted load is within a tenth of that of finite elements.
    pub close: f64,
    /// Fraction whose load of finite elements is within the interval; None without an interval.
    pub covered: Option<f64>,
    /// Median of the error of the load, relative.
    pub median: f64,
}

/// Compares the loads at which the test grasps of `split` slip; None if none of them was dropped under a push.
///
/// # Errors
/// Fails if data cannot be read.
pub fn slip_loads(set: &DataSet, predictor: &Predictor, split: &str) -> Result<Option<SlipEvaluation>> {
    let poses = data::split(&[&set.splits], split)?.remove(0).test;
    let slipped = slipped::read(&[(set, &poses)], &predictor.pads)?;
    let margins: Vec<FrictionMargin> =
        slipped.par_iter().filter_map(|grasp| Some(grasp.slip_load(predictor)?.margin(predictor))).collect();
    // The predicted load over that of finite elements is the reciprocal of the used fraction.
    let mut errors: Vec<f64> = margins.iter().map(|margin| (1.0 / (1.0 - margin.expected) - 1.0).abs()).collect();
    errors.sort_by(f64::total_cmp);
    let part = |count: usize| count as f64 / margins.len() as f64;
    let covered = margins.iter().filter(|m| m.interval[0] <= 0.0 && 0.0 <= m.interval[1]).count();
    Ok(errors.get(errors.len() / 2).map(|median| SlipEvaluation {
        grasps: margins.len(),
        close: part(errors.iter().filter(|error| **error <= CLOSE).count()),
        covered: predictor.card.slip.map(|_| part(covered)),
        median: *median,
    }))
}
