//! Grasps that the network keeps where its error is bounded, and those that it hands over.

use super::Judged;
use crate::net::eval::table::FROM_LOAD;
use crate::stats::Spread;
use serde::Serialize;

/// Bounds of the error that are looked at.
const BOUNDS: [f64; 4] = [0.05, 0.1, 0.2, 0.4];

/// Outcome of `error_at_most` on judged grasps.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Acceptance {
    /// Largest error of the displacement that is accepted, relative.
    pub error_at_most: f64,
    /// Part of the grasps that the network keeps: whose interval is as narrow in all frames.
    pub kept: f64,
    /// Median error of their displacement, relative; zero without any.
    pub median: f64,
    /// Worst error of their displacement, relative; zero without any.
    pub worst: f64,
}

/// Returns what each of some bounds would do; empty where the network knows its error of no grasp.
pub fn acceptances(judged: &[Judged]) -> Vec<Acceptance> {
    let widest = |j: &Judged| j.frames.iter().map(|frame| frame.bound.displacement).fold(0.0, f64::max);
    let widest: Vec<f64> = judged.iter().map(widest).collect();
    if !widest.iter().any(|end| end.is_finite()) {
        return Vec::new();
    }
    let of = |error_at_most: f64| {
        let kept: Vec<&Judged> =
            judged.iter().zip(&widest).filter(|(_, end)| **end <= error_at_most).map(|(j, _)| j).collect();
        let frames = kept.iter().flat_map(|j| &j.frames).filter(|frame| frame.load >= FROM_LOAD - 1e-9);
        let spread = Spread::of(frames.map(|frame| frame.displacement));
        Acceptance {
            error_at_most,
            kept: kept.len() as f64 / judged.len().max(1) as f64,
            median: spread.map_or(0.0, |s| s.median),
            worst: spread.map_or(0.0, |s| s.worst),
        }
    };
    BOUNDS.into_iter().map(of).collect()
}
