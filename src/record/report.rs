//! `run.json`: the run, the outcome of every grasp and the expectations of the scene. Keys end in their unit.

use super::ErrorBound;
use super::frame::Frame;
use super::sensitivity::ChangeEffect;
pub use super::status::Status;
use base::error::{Error, Result};
use base::files::atomic::write_atomic;
use base::machine::machine;
use mech::path::continuation::MethodCounts;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Summary of a grasp. Numbers that do not exist (a grasp without frames) are `null` in the file, never NaN.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GraspSummary {
    /// Index of the grasp in its scene, from 0.
    pub grasp: usize,
    /// Outcome of the grasp.
    pub status: Status,
    /// Reason if the load was not reached; otherwise `None`.
    pub reason: Option<String>,
    /// Applied force of the last frame, sum over the fingers, N; 0 without frames.
    pub force_n: f64,
    /// Travel at the last frame, mean over the fingers, m; 0 without frames.
    pub travel_m: f64,
    /// Number of recorded frames.
    pub frames: usize,
    /// Smallest det F over all frames.
    pub min_det_f: Option<f64>,
    /// Smallest gap over all frames, m.
    pub min_gap_m: Option<f64>,
    /// Largest relative force imbalance over all frames.
    pub force_balance: Option<f64>,
    /// Total number of Newton iterations.
    pub newton_iterations: u64,
    /// Counts of how often each method of the continuation was used.
    #[serde(default)]
    pub methods: MethodCounts,
    /// Wall time of the grasp, s.
    pub wall_s: f64,
    /// Error of the last frame as estimated by the network; None for frames computed by finite elements.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<ErrorBound>,
    /// Reason for which finite elements computed the grasp instead of the network.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub handed_over: Option<String>,
    /// Effects of small changes on the last frame, if requested.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensitivity: Vec<ChangeEffect>,
}

impl GraspSummary {
    /// Returns the summary of a grasp without frames yet.
    pub fn new(status: Status, reason: Option<String>) -> Self {
        GraspSummary {
            grasp: 0,
            status,
            reason,
            force_n: 0.0,
            travel_m: 0.0,
            frames: 0,
            min_det_f: None,
            min_gap_m: None,
            force_balance: None,
            newton_iterations: 0,
            methods: MethodCounts::default(),
            wall_s: 0.0,
            error: None,
            handed_over: None,
            sensitivity: Vec::new(),
        }
    }

    /// Updates the summary with the next frame.
    pub fn observe(&mut self, frame: &Frame) {
        let fold = |old: Option<f64>, new: f64, pick: fn(f64, f64) -> f64| Some(old.map_or(new, |old| pick(old, new)));
        self.force_n = frame.applied_force;
        self.travel_m = frame.travel.iter().sum::<f64>() / frame.travel.len().max(1) as f64;
        self.frames += 1;
        if frame.min_det_f.is_finite() {
            self.min_det_f = fold(self.min_det_f, frame.min_det_f, f64::min);
        }
        if frame.min_gap.is_finite() {
            self.min_gap_m = fold(self.min_gap_m, frame.min_gap, f64::min);
        }
        self.force_balance = fold(self.force_balance, frame.force_balance, f64::max);
        self.newton_iterations += u64::from(frame.newton_iterations);
        self.error = frame.error;
    }

    /// Returns the first non-finite number, if any, because serde would silently write `null` for it.
    fn not_finite(&self) -> Option<(&'static str, f64)> {
        let numbers = [
            ("force_n", Some(self.force_n)),
            ("travel_m", Some(self.travel_m)),
            ("min_det_f", self.min_det_f),
            ("min_gap_m", self.min_gap_m),
            ("force_balance", self.force_balance),
            ("wall_s", Some(self.wall_s)),
        ];
        numbers.into_iter().find_map(|(name, value)| value.filter(|v| !v.is_finite()).map(|v| (name, v)))
    }
}

/// Result of an expectation of the scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ExpectationReport {
    /// Name as in the scene, e.g. `ForceBalance`.
    pub name: String,
    /// True if the expectation is met in every grasp.
    pub held: bool,
    /// Worst value; `None` if there was no frame to evaluate.
    pub value: Option<f64>,
    /// Bound for the value.
    pub bound: Option<f64>,
}

/// Discretisation of one pad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PadReport {
    /// `left` or `right`.
    pub name: String,
    /// Number of nodes, including mid-edge nodes.
    pub nodes: usize,
    /// Number of tetrahedra.
    pub tets: usize,
    /// `linear` or `quadratic`, with the volumetric treatment, e.g. `quadratic, mean dilatation`.
    pub element: String,
    /// Notice for the user, e.g. that linear tetrahedra lock at this Poisson's ratio.
    pub notice: Option<String>,
}

/// Content of `run.json` and of `tactus run --format json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunReport {
    /// Version of tactus.
    pub tactus: String,
    /// Backend that advanced the state: `fem` or `gnn`, with settings if it has any.
    pub backend: String,
    /// Number of threads.
    pub threads: usize,
    /// Command line of the run, its program without the folder; empty in older files.
    #[serde(default)]
    pub command: String,
    /// Processor and number of cores of the machine; empty in older files.
    #[serde(default)]
    pub machine: String,
    /// False until the run has finished, so that an interrupted run is recognisable.
    pub finished: bool,
    /// Scene with every default and include resolved.
    pub scene: serde_json::Value,
    /// Discretisations of the pads, left first.
    pub pads: Vec<PadReport>,
    /// Warnings about the validity of the results, one sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notices: Vec<String>,
    /// Summaries of the grasps, in order.
    pub grasps: Vec<GraspSummary>,
    /// Field of the scene that states the expectations: `expect` or `expect_network`.
    #[serde(default, rename = "promised_in")]
    pub expectations_source: String,
    /// Results of the expectations.
    pub expectations: Vec<ExpectationReport>,
    /// Wall time by stage, s.
    pub profile_s: BTreeMap<String, f64>,
}

/// Returns the command line of this process, its program without the folder.
fn command() -> String {
    let mut words: Vec<String> = std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
    if let Some(program) = words.first_mut() {
        *program = Path::new(program.as_str()).file_name().map_or_else(String::new, |n| n.to_string_lossy().into());
    }
    words.join(" ")
}

impl RunReport {
    /// Returns an empty report of this version of tactus.
    pub fn new(backend: impl Into<String>, threads: usize, scene: serde_json::Value) -> Self {
        RunReport {
            tactus: env!("CARGO_PKG_VERSION").into(),
            backend: backend.into(),
            threads,
            command: command(),
            machine: machine(),
            finished: false,
            scene,
            pads: Vec::new(),
            notices: Vec::new(),
            grasps: Vec::new(),
            expectations_source: String::new(),
            expectations: Vec::new(),
            profile_s: BTreeMap::new(),
        }
    }

    /// Returns the report as indented JSON.
    ///
    /// # Errors
    /// Fails if a number is not finite; the message names the first such number.
    pub fn to_json(&self) -> std::result::Result<String, String> {
        for (index, grasp) in self.grasps.iter().enumerate() {
            if let Some((name, value)) = grasp.not_finite() {
                return Err(format!("grasp {index}: {name} is {value}, only finite numbers are written"));
            }
        }
        for expectation in &self.expectations {
            if let Some(value) = [expectation.value, expectation.bound].into_iter().flatten().find(|v| !v.is_finite()) {
                return Err(format!("expectation {}: {value}, only finite numbers are written", expectation.name));
            }
        }
        if let Some((stage, value)) = self.profile_s.iter().find(|(_, v)| !v.is_finite()) {
            return Err(format!("profile_s.{stage} is {value}, only finite numbers are written"));
        }
        serde_json::to_string_pretty(self).map(|text| text + "\n").map_err(|e| e.to_string())
    }

    /// Writes the report to `path`; the file is replaced atomically.
    ///
    /// # Errors
    /// Fails if a number is not finite or the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = self.to_json().map_err(|message| Error::file(path, format!("not written: {message}")))?;
        write_atomic(path, text.as_bytes())
    }
}
