//! Report of a contest: a point per configuration, the Pareto front, the speed-up at equal error.

use super::contest::{ContestEntry, Rules};
use super::front::{Rival, time_at};
use super::ladder::MeshLadder;
use crate::distance::Distance;
use crate::stats::Spread;
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Name of a quantity or a stage; owned if it was read from `bench.json`.
pub type QuantityName = Cow<'static, str>;

/// Time and error of one configuration. Times are wall times unless stated otherwise; relative errors have no unit.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Point {
    /// Name of the configuration.
    pub label: String,
    /// Backend: `fem` or `gnn`.
    pub backend: String,
    /// True for a network or a fast mode, to which the speed-up refers.
    pub contender: bool,
    /// Number of nodes of one pad.
    pub nodes: usize,
    /// Number of unknowns of the solver; null for a network.
    pub unknowns: Option<usize>,
    /// Time of the set-up and the first grasp, s.
    #[serde(deserialize_with = "number")]
    pub cold_s: f64,
    /// Time of a grasp with all its frames, warm, s: median over the turns, then over the grasps.
    #[serde(deserialize_with = "number")]
    pub time_per_grasp_s: f64,
    /// Time of a grasp over the number of frames, s.
    #[serde(deserialize_with = "number")]
    pub time_per_frame_s: f64,
    /// Processor time of all threads for a grasp, s; null if the system does not provide it.
    pub processor_time_per_grasp_s: Option<f64>,
    /// Number of Newton iterations (decoder passes) per frame.
    pub iterations_per_frame: f64,
    /// Error of the displacement, median of `errors`; null if no grasp reached its end.
    pub displacement_error: Option<f64>,
    /// Error of the von Mises stress, median.
    pub stress_error: Option<f64>,
    /// Error of the contact force, median.
    pub force_error: Option<f64>,
    /// Error of the travel of the fingers, median.
    pub travel_error: Option<f64>,
    /// Median, 90th percentile and worst of every quantity over grasps and frames.
    pub errors: BTreeMap<QuantityName, Spread>,
    /// Grasps that did not reach their end, with the reason.
    pub failed: Vec<String>,
    /// True if another point is as fast and as accurate, or some grasp failed.
    pub dominated: bool,
    /// Time that full finite elements take for the same accuracy, along the Pareto front of their settings, over this one's; only for
    /// contenders.
    pub speedup_at_equal_error: Option<f64>,
    /// Setting at that point, or the two that it lies between.
    pub equal_error_label: Option<String>,
    /// True if the cheapest setting is more accurate: the speed-up is at most this.
    #[serde(default)]
    pub speedup_is_bound: bool,
    /// Share of each stage in the time.
    pub profile: BTreeMap<QuantityName, f64>,
    /// Largest resident memory of the process with this configuration alone, up to its first frame, bytes; null if the
    /// system does not provide it.
    pub peak_memory_bytes: Option<u64>,
}

/// Reads null as NaN, because JSON has no NaN.
fn number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// Quantity with its name and the function that reads it.
type Quantity = (&'static str, fn(&Distance) -> f64);

/// Quantities that are compared; a name without unit is relative.
pub const QUANTITIES: [Quantity; 6] = [
    ("displacement", |e| e.displacement),
    ("stress", |e| e.stress),
    ("force", |e| e.force),
    ("travel", |e| e.travel),
    ("displacement_max_m", |e| e.displacement_max_m),
    ("stress_max_pa", |e| e.stress_max_pa),
];

/// Report of a contest.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct BenchReport {
    /// Numbers of the grasps.
    pub grasps: Vec<usize>,
    /// Number of threads of each grasp.
    pub threads: usize,
    /// Number of turns of each configuration on each grasp.
    pub repeats: usize,
    /// Time and error of each configuration.
    pub points: Vec<Point>,
    /// Reference of the comparison; its errors are estimates.
    pub reference: Point,
    /// Error of the reference's displacement, as the ladder estimates it; smaller errors cannot be distinguished.
    pub reference_error: Option<f64>,
    /// Ladder from which the error of the reference is estimated.
    pub ladder: MeshLadder,
    /// Largest speed-up of the contenders; null without any, or if no setting reaches their error.
    pub speedup_at_equal_error: Option<f64>,
    /// Notices for the reader of the numbers.
    pub notices: Vec<String>,
}

impl BenchReport {
    /// Builds the report from the entries of a contest.
    pub fn new(
        rules: &Rules,
        grasps: Vec<usize>,
        (reference, ladder): (&ContestEntry, MeshLadder),
        entries: &[ContestEntry],
        notices: Vec<String>,
    ) -> Self {
        let mut points: Vec<Point> = entries.iter().map(Point::new).collect();
        let mut reference = Point::new(reference);
        let of = |name: &str| ladder.errors.get(name).and_then(|e| e.error);
        let reference_error = of("displacement");
        (reference.displacement_error, reference.stress_error) = (reference_error, of("stress"));
        (reference.force_error, reference.travel_error) = (of("force"), of("travel"));
        mark_dominated(&mut points);
        let mut settings: Vec<Point> = points.iter().filter(|p| !p.contender).cloned().collect();
        settings.push(reference.clone());
        points.iter_mut().filter(|p| p.contender).for_each(|p| p.compare(&settings));
        let speedups = points.iter().filter_map(|p| p.speedup_at_equal_error);
        Self {
            grasps,
            threads: rules.threads,
            repeats: rules.repeats,
            speedup_at_equal_error: speedups.reduce(f64::max),
            reference_error,
            ladder,
            reference,
            points,
            notices,
        }
    }
}

/// Marks points that another one beats: as fast and as accurate in displacement, and better in one of the two.
pub fn mark_dominated(points: &mut [Point]) {
    let all: Vec<Option<(f64, f64)>> = points.iter().map(Point::place).collect();
    for (point, own) in points.iter_mut().zip(&all) {
        let beaten =
            |own: &(f64, f64)| all.iter().flatten().any(|other| other.0 <= own.0 && other.1 <= own.1 && other != own);
        point.dominated = own.as_ref().is_none_or(beaten);
    }
}

impl Point {
    fn new(entry: &ContestEntry) -> Self {
        let spread =
            |(name, pick): &Quantity| Spread::of(entry.errors.iter().map(pick)).map(|s| (QuantityName::from(*name), s));
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
            unknowns: model.filter(|_| backend == "fem").map(|m| m.unknowns().total),
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
            equal_error_label: None,
            speedup_is_bound: false,
            profile: entry.stages.iter().map(|(stage, s)| (QuantityName::from(*stage), s / whole)).collect(),
            peak_memory_bytes: entry.peak_memory,
        }
    }

    /// Returns time and displacement error; None if a grasp failed.
    pub fn place(&self) -> Option<(f64, f64)> {
        self.displacement_error.filter(|_| self.failed.is_empty()).map(|e| (self.time_per_grasp_s, e))
    }

    /// Compares with `settings`: the time that they take to have at most this point's errors of displacement and stress,
    /// over its own time.
    fn compare(&mut self, settings: &[Point]) {
        let sound: Vec<&Point> = settings.iter().filter(|p| p.failed.is_empty()).collect();
        let at = |pick: fn(&Point) -> Option<f64>| {
            let rivals = sound
                .iter()
                .copied()
                .filter_map(|p| Some(Rival { label: &p.label, time: p.time_per_grasp_s, error: pick(p)? }));
            let rivals: Vec<Rival> = rivals.collect();
            time_at(&rivals, pick(self)?)
        };
        let (Some(displacement), Some(stress)) = (at(|p| p.displacement_error), at(|p| p.stress_error)) else { return };
        let equal = if displacement.time >= stress.time { displacement } else { stress };
        self.speedup_at_equal_error = Some(equal.time / self.time_per_grasp_s);
        (self.speedup_is_bound, self.equal_error_label) = (equal.bound, Some(equal.label));
    }

    /// Returns the speed-up in words, if there is one.
    pub fn speedup(&self) -> Option<String> {
        let (ratio, label) = self.speedup_at_equal_error.zip(self.equal_error_label.as_ref())?;
        Some(match self.speedup_is_bound {
            false => format!("{ratio:.1} (against {label})"),
            true => format!("at most {ratio:.1} (against {label}, the cheapest, which is more accurate)"),
        })
    }
}
