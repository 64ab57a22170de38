//! Number and error of the grasps that the network keeps under a bound on its predicted error; the others fall back to
//! finite elements.

use super::GraspEvaluation;
use crate::eval::table::MIN_LOAD_FRACTION;
use base::stats::Quantiles;
use serde::Serialize;

/// Bounds on the error that are evaluated.
const BOUNDS: [f64; 4] = [0.05, 0.1, 0.2, 0.4];

/// Outcome of `error_at_most` on judged grasps.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Acceptance {
    /// Largest error of the displacement that is accepted, relative.
    pub error_at_most: f64,
    /// Fraction of the grasps that the network keeps: those whose prediction interval is within the bound in all
    /// frames.
    pub kept: f64,
    /// Median relative error of their displacement, from [`MIN_LOAD_FRACTION`] on; zero if there are none.
    pub median: f64,
    /// Largest relative error of their displacement, from [`MIN_LOAD_FRACTION`] on; zero if there are none.
    pub worst: f64,
}

/// Returns the outcome of several bounds; empty if no grasp has a prediction interval.
pub fn acceptances(judged: &[GraspEvaluation]) -> Vec<Acceptance> {
    let widest = |j: &GraspEvaluation| j.frames.iter().map(|frame| frame.bound.displacement).fold(0.0, f64::max);
    let widest: Vec<f64> = judged.iter().map(widest).collect();
    if !widest.iter().any(|end| end.is_finite()) {
        return Vec::new();
    }
    let of = |error_at_most: f64| {
        let kept: Vec<&GraspEvaluation> =
            judged.iter().zip(&widest).filter(|(_, end)| **end <= error_at_most).map(|(j, _)| j).collect();
        let frames = kept.iter().flat_map(|j| &j.frames).filter(|frame| frame.load >= MIN_LOAD_FRACTION - 1e-9);
        let spread = Quantiles::from_values(frames.map(|frame| frame.displacement));
        Acceptance {
            error_at_most,
            kept: kept.len() as f64 / judged.len().max(1) as f64,
            median: spread.map_or(0.0, |s| s.median),
            worst: spread.map_or(0.0, |s| s.worst),
        }
    };
    BOUNDS.into_iter().map(of).collect()
}
