//! Report of a comparison: a point per configuration, the Pareto front, the speed-up at equal error.

use super::entry::BenchEntry;
use super::pareto_front::{Competitor, time_at};
use super::quantity::ComparedQuantity;
pub use super::quantity::{QUANTITIES, QuantityName};
use super::refinement_study::RefinementStudy;
use super::settings::ComparisonSettings;
use base::stats::Quantiles;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;

/// Name of the finite-element backend.
const FEM: &str = "fem";

/// Time and error of one configuration. Times are wall times unless stated otherwise; relative errors have no unit.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Point {
    /// Name of the configuration.
    pub label: String,
    /// Backend: `fem` or `gnn`.
    pub backend: String,
    /// True for a network or a fast mode, for which a speed-up is reported.
    pub contender: bool,
    /// Number of nodes of one pad.
    pub nodes: usize,
    /// Number of unknowns of the solver; null for a network.
    pub unknowns: Option<usize>,
    /// Time of the set-up and the first grasp, s.
    #[serde(deserialize_with = "number")]
    pub cold_s: f64,
    /// Time of a grasp with all its frames, without set-up, s: median over the repetitions, then over the grasps.
    #[serde(deserialize_with = "number")]
    pub time_per_grasp_s: f64,
    /// Time of a grasp over the number of frames, s.
    #[serde(deserialize_with = "number")]
    pub time_per_frame_s: f64,
    /// Processor time of all threads for a grasp, s; null if the system does not provide it.
    pub processor_time_per_grasp_s: Option<f64>,
    /// Number of Newton iterations (decoder passes) per frame.
    pub iterations_per_frame: f64,
    /// Error of the displacement, median of `errors`; null if no grasp reached its load.
    pub displacement_error: Option<f64>,
    /// Error of the von Mises stress, median.
    pub stress_error: Option<f64>,
    /// Error of the contact force, median.
    pub force_error: Option<f64>,
    /// Error of the travel of the fingers, median.
    pub travel_error: Option<f64>,
    /// Median, 90th percentile and worst of every quantity over grasps and frames.
    pub errors: BTreeMap<QuantityName, Quantiles>,
    /// Grasps that did not reach their load, with the reason.
    pub failed: Vec<String>,
    /// True if another point is at least as fast and as accurate and better in one of the two, or if a grasp failed.
    pub dominated: bool,
    /// Speed-up over full (uncondensed) pad models and the reference at equal error; only for contenders.
    pub speedup_at_equal_error: Option<SpeedUp>,
    /// Speed-up over the fastest finite elements of equal error, fast modes included; only for networks.
    pub speedup_over_cheapest: Option<SpeedUp>,
    /// Fraction of the time spent in each stage.
    pub profile: BTreeMap<QuantityName, f64>,
    /// Largest resident memory of the process with this configuration alone, up to its first frame, bytes; null if the
    /// system does not provide it.
    pub peak_memory_bytes: Option<u64>,
}

/// Time that other settings take for the same error, along their Pareto front, over a point's own time.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SpeedUp {
    /// Ratio of the times.
    pub ratio: f64,
    /// Setting at that point of the front, or the two between which it is interpolated.
    pub against: String,
    /// True if even the fastest setting is more accurate; `ratio` is then an upper bound.
    pub is_bound: bool,
}

impl std::fmt::Display for SpeedUp {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { ratio, against, is_bound } = self;
        match is_bound {
            false => write!(f, "{ratio:.1} (against {against})"),
            true => write!(f, "at most {ratio:.1} (against {against}, the cheapest, which is more accurate)"),
        }
    }
}

/// Published times of a grasp with the simulator of the tactile paper, DefGraspSim on a GPU, s: 2 to 7 minutes
/// according to its users; not measured here.
const PUBLISHED: [f64; 2] = [120.0, 420.0];

/// Reads null as NaN, because JSON has no NaN.
fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// Report of a comparison.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct BenchReport {
    /// Numbers of the grasps.
    pub grasps: Vec<usize>,
    /// Number of threads of each grasp.
    pub threads: usize,
    /// Number of repetitions of each grasp by each configuration.
    pub repeats: usize,
    /// Time and error of each configuration.
    pub points: Vec<Point>,
    /// Reference of the comparison; its errors are estimated.
    pub reference: Point,
    /// Estimated error of the displacement of the reference; smaller errors cannot be resolved.
    pub reference_error: Option<f64>,
    /// Mesh refinement study from which the error of the reference is estimated.
    #[serde(rename = "ladder")]
    pub refinement_study: RefinementStudy,
    /// Largest speed-up of the contenders; null without any, or if no setting reaches their error.
    pub speedup_at_equal_error: Option<f64>,
    /// Notices about the results.
    pub notices: Vec<String>,
}

impl BenchReport {
    /// Builds the report from the entries of a comparison.
    pub fn new(
        settings: &ComparisonSettings,
        grasps: Vec<usize>,
        (reference, study): (&BenchEntry, RefinementStudy),
        entries: &[BenchEntry],
        notices: Vec<String>,
    ) -> Self {
        let mut points: Vec<Point> = entries.iter().map(Point::new).collect();
        let mut reference = Point::new(reference);
        let of = |name: &str| study.errors.get(name).and_then(|e| e.error);
        let reference_error = of("displacement");
        (reference.displacement_error, reference.stress_error) = (reference_error, of("stress"));
        (reference.force_error, reference.travel_error) = (of("force"), of("travel"));
        mark_dominated(&mut points);
        let mut full_models: Vec<Point> = points.iter().filter(|p| !p.contender).cloned().collect();
        full_models.push(reference.clone());
        let mut elements: Vec<Point> = points.iter().filter(|p| p.backend == FEM).cloned().collect();
        elements.push(reference.clone());
        for point in points.iter_mut().filter(|p| p.contender) {
            point.speedup_at_equal_error = point.compare(&full_models);
            if point.backend != FEM {
                point.speedup_over_cheapest = point.compare(&elements);
            }
        }
        let speedups = points.iter().filter_map(|p| Some(p.speedup_at_equal_error.as_ref()?.ratio));
        Self {
            grasps,
            threads: settings.threads,
            repeats: settings.repeats,
            speedup_at_equal_error: speedups.reduce(f64::max),
            reference_error,
            refinement_study: study,
            reference,
            points,
            notices,
        }
    }
}

/// Marks dominated points: another point is at least as fast and as accurate in displacement, and better in one of the
/// two.
pub fn mark_dominated(points: &mut [Point]) {
    let all: Vec<Option<(f64, f64)>> = points.iter().map(Point::time_and_error).collect();
    for (point, own) in points.iter_mut().zip(&all) {
        let beaten =
            |own: &(f64, f64)| all.iter().flatten().any(|other| other.0 <= own.0 && other.1 <= own.1 && other != own);
        point.dominated = own.as_ref().is_none_or(beaten);
    }
}

impl Point {
    fn new(entry: &BenchEntry) -> Self {
        let spread = |(name, pick): &ComparedQuantity| {
            Quantiles::from_values(entry.errors.iter().map(pick)).map(|s| (QuantityName::from(*name), s))
        };
        let errors: BTreeMap<_, _> = QUANTITIES.iter().filter_map(spread).collect();
        let middle = |name: &str| errors.get(name).map(|s| s.median);
        let whole: f64 = entry.stages.values().sum();
        let model = entry.prepared.as_ref().map(|p| &p.model);
        let backend = entry.prepared.as_ref().map_or("", |p| p.stepper.name());
        let runs = entry.wall_s.values().map(Vec::len).sum::<usize>().max(1);
        let time = entry.time_per_grasp();
        Self {
            label: entry.configuration.label.clone(),
            backend: backend.into(),
            contender: entry.configuration.contender,
            nodes: entry.configuration.nodes,
            unknowns: model.filter(|_| backend == FEM).map(|m| m.unknowns().total),
            cold_s: entry.cold_s,
            time_per_grasp_s: time,
            time_per_frame_s: time * runs as f64 / entry.frames.max(1) as f64,
            processor_time_per_grasp_s: entry.processor_time_per_grasp(),
            iterations_per_frame: entry.iterations as f64 / entry.frames.max(1) as f64,
            displacement_error: middle("displacement"),
            stress_error: middle("stress"),
            force_error: middle("force"),
            travel_error: middle("travel"),
            errors,
            failed: entry.failed.clone(),
            dominated: false,
            speedup_at_equal_error: None,
            speedup_over_cheapest: None,
            profile: entry.stages.iter().map(|(stage, s)| (QuantityName::from(*stage), s / whole)).collect(),
            peak_memory_bytes: entry.peak_memory,
        }
    }

    /// Returns time and displacement error; None if a grasp failed.
    pub fn time_and_error(&self) -> Option<(f64, f64)> {
        self.displacement_error.filter(|_| self.failed.is_empty()).map(|e| (self.time_per_grasp_s, e))
    }

    /// Returns the speed-up over `settings`: the time that they take for at most this point's errors of displacement
    /// and stress, over its own time. None if no setting reaches them.
    fn compare(&self, settings: &[Point]) -> Option<SpeedUp> {
        let sound: Vec<&Point> = settings.iter().filter(|p| p.failed.is_empty()).collect();
        let at = |pick: fn(&Point) -> Option<f64>| {
            let rivals = sound
                .iter()
                .copied()
                .filter_map(|p| Some(Competitor { label: &p.label, time: p.time_per_grasp_s, error: pick(p)? }));
            let rivals: Vec<Competitor> = rivals.collect();
            time_at(&rivals, pick(self)?)
        };
        let (displacement, stress) = (at(|p| p.displacement_error)?, at(|p| p.stress_error)?);
        let equal = if displacement.time >= stress.time { displacement } else { stress };
        let ratio = equal.time / self.time_per_grasp_s;
        Some(SpeedUp { ratio, against: equal.label, is_bound: equal.bound })
    }

    /// Returns the speed-ups of a contender, one sentence each: over full pad models, and those of a network also over
    /// the fastest finite elements and over the published simulator.
    pub fn speedups(&self) -> Vec<String> {
        let words = |speedup: &Option<SpeedUp>| {
            speedup.as_ref().map_or_else(|| "no other setting reaches its error".into(), SpeedUp::to_string)
        };
        let mut all =
            vec![format!("speed-up at equal error of {}: {}", self.label, words(&self.speedup_at_equal_error))];
        if self.backend != FEM {
            all.push(format!(
                "over the cheapest finite elements of equal error: {}",
                words(&self.speedup_over_cheapest)
            ));
            let [least, most] = PUBLISHED.map(|time| time / self.time_per_grasp_s);
            all.push(format!(
                "over the published 2 to 7 minutes per grasp of the simulator of the tactile paper on a GPU, not \
                 measured here: {least:.0} to {most:.0}"
            ));
        }
        all
    }
}
