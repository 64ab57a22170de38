//! Medians, 90th percentiles and worst values of the errors, over all frames and by object, load and frame.

use super::{FrameError, GraspEvaluation};
use crate::eval::rank_correlation::kendall;
use base::stats::Quantiles;
use record::ErrorBound;
use serde::Serialize;
use std::collections::BTreeMap;

/// Fraction of the last force below which frames are excluded from the groups `all` and `object`: deformation is almost
/// zero there, so that relative errors are meaningless.
pub const MIN_LOAD_FRACTION: f64 = 0.2;

/// Error of one quantity over one group of frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ErrorRow {
    /// Evaluated split.
    pub split: String,
    /// Group: `all`, `object NAME`, `load 20-40 %`, `frame K`.
    pub group: String,
    /// Quantity; relative if its name has no unit.
    pub quantity: &'static str,
    /// Median.
    pub median: f64,
    /// 90th percentile.
    pub p90: f64,
    /// Largest value.
    pub worst: f64,
    /// Number of frames.
    pub samples: usize,
    /// Fraction of the frames with a prediction interval whose error is within it; None if there are none.
    pub covered: Option<f64>,
    /// Median upper end of the intervals.
    pub interval: Option<f64>,
}

/// Name of a quantity, and functions that return its error and the upper end of its prediction interval.
type Quantity = (&'static str, fn(&FrameError) -> f64, fn(&ErrorBound) -> Option<f64>);

const QUANTITIES: [Quantity; 11] = [
    ("displacement", |e| e.displacement, |b| Some(b.displacement)),
    ("displacement_mm", |e| e.displacement_mm, |_| None),
    ("displacement_worst_mm", |e| e.displacement_worst_mm, |_| None),
    ("stress", |e| e.stress, |b| Some(b.stress)),
    ("stress_kpa", |e| e.stress_kpa, |_| None),
    ("contact_force", |e| e.contact_force, |_| None),
    ("traction", |e| e.traction, |_| None),
    ("travel", |e| e.travel, |b| Some(b.travel)),
    ("travel_mm", |e| e.travel_mm, |_| None),
    ("object_mm", |e| e.object_mm, |_| None),
    ("object_deg", |e| e.object_deg, |_| None),
];

/// Group of all frames from [`MIN_LOAD_FRACTION`] on.
pub const ALL: &str = "all";

/// Returns all rows of a split.
pub fn rows(split: &str, judged: &[GraspEvaluation]) -> Vec<ErrorRow> {
    let frames: Vec<&FrameError> = judged.iter().flat_map(|j| &j.frames).collect();
    let mut groups: BTreeMap<(u8, String), Vec<&FrameError>> = BTreeMap::new();
    for frame in frames {
        let fifth = ((frame.load * 5.0 - 1e-9).floor() as usize).min(4);
        let loaded = frame.load >= MIN_LOAD_FRACTION - 1e-9;
        let names = [
            loaded.then(|| (0, ALL.to_string())),
            loaded.then(|| (1, format!("object {}", frame.object))),
            Some((2, format!("load {}-{} %", 20 * fifth, 20 * fifth + 20))),
            Some((3, format!("frame {:03}", frame.frame))),
        ];
        names.into_iter().flatten().for_each(|name| groups.entry(name).or_default().push(frame));
    }
    let row = |(group, frames): (&(u8, String), &Vec<&FrameError>)| {
        let of = |(quantity, pick, end): &Quantity| {
            let Quantiles { median, p90, worst } = Quantiles::from_values(frames.iter().map(|f| pick(f)))?;
            let ends = frames.iter().filter(|f| f.bound.is_known()).filter_map(|f| Some((pick(f), end(&f.bound)?)));
            let ends: Vec<(f64, f64)> = ends.collect();
            Some(ErrorRow {
                split: split.into(),
                group: group.1.clone(),
                quantity,
                median,
                p90,
                worst,
                samples: frames.len(),
                covered: (!ends.is_empty())
                    .then(|| ends.iter().filter(|(error, end)| error <= end).count() as f64 / ends.len() as f64),
                interval: Quantiles::from_values(ends.iter().map(|(_, end)| *end)).map(|spread| spread.median),
            })
        };
        QUANTITIES.iter().filter_map(of).collect::<Vec<_>>()
    };
    groups.iter().flat_map(row).collect()
}

/// Returns Kendall's tau between truth and prediction, of the grasps ranked by peak stress and by peak displacement of
/// their last frame.
pub fn ranks(judged: &[GraspEvaluation]) -> (f64, f64) {
    let list =
        |which: usize, pick: fn(&super::Peak) -> f64| judged.iter().map(|j| pick(&j.peaks[which])).collect::<Vec<_>>();
    let tau = |pick: fn(&super::Peak) -> f64| kendall(&list(0, pick), &list(1, pick));
    (tau(|p| p.stress), tau(|p| p.displacement))
}
