//! Execution of all grasps of a scene, from the scene to the verdict: `tactus run` and `tactus.run` of Python.

use crate::choose;
use base::error::{Error, Result};
use base::machine::machine_threads;
use base::number::format_count;
use geometry::Pose;
use model::Model;
use model::evaluation::{GraspMeasurements, Verdict, evaluate_all};
use model::grasp::{aim_notice, grasp_poses};
use record::render::Scalar;
use record::{ExpectationReport, RunReport, Status};
use scene::{Scene, StepperChoice};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use world::Stepper;
use world::run::sensitivity::{FinalStates, LastFrames, sensitivity};
use world::run::writer::RunWriter;
use world::run::{Observer, Outcome, RecordingOptions, RunRecorder, run_grasps};

/// Scene that is ready to run.
#[derive(Debug)]
pub struct Simulation {
    /// Scene.
    pub scene: Scene,
    /// Data that no grasp changes.
    pub model: Arc<Model>,
    /// Numbers and poses of the grasps.
    pub grasps: Vec<(usize, Pose)>,
    /// Number of threads.
    pub threads: usize,
    /// Notices for the user, one sentence each.
    pub notices: Vec<String>,
    stepper: Box<dyn Stepper>,
}

/// Simulated grasps.
#[derive(Debug)]
pub struct SimulationResult {
    /// Outcomes in the order of the grasps.
    pub outcomes: Vec<Outcome>,
    /// Verdicts on the expectations of the scene.
    pub verdicts: Vec<Verdict>,
    /// Content of `run.json`.
    pub report: RunReport,
    /// Wall time of all grasps together, s.
    pub wall_s: f64,
}

impl Simulation {
    /// Builds everything that the grasps of a scene share. `wanted` are the numbers of the grasps to run, in this
    /// order; all if it is empty. `threads` overrides the number of threads of the scene or of the machine.
    ///
    /// # Errors
    /// Fails if the model cannot be built, the network cannot be read or does not support it, or a wanted grasp does
    /// not exist.
    pub fn new(scene: &Scene, wanted: &[usize], threads: Option<usize>) -> Result<Self> {
        // Reading a network takes as long as meshing the pads.
        let (stepper, model) = rayon::join(|| choose(scene), || Model::build(scene));
        let (stepper, model) = (stepper?, model?);
        stepper.check_support(&model)?;
        let poses = grasp_poses(scene)?;
        let pad = model.pad_bounds();
        let aim = pad.and_then(|pad| aim_notice(scene, &model.object, pad, &poses));
        let own = match &scene.stepper {
            StepperChoice::Fem(fem) => fem.threads.map(|t| t.get()),
            StepperChoice::Gnn(_) => None,
        };
        Ok(Self {
            grasps: select(&poses, wanted)?,
            threads: threads.or(own).unwrap_or_else(machine_threads),
            notices: {
                let own = model.notices.iter().cloned().chain(model.pad_notices());
                own.chain(aim).chain(stepper.notices(&model)).collect()
            },
            scene: scene.clone(),
            model,
            stepper,
        })
    }

    /// Creates the folder of the run, and an observer that writes into it.
    ///
    /// # Errors
    /// Fails if the folder holds an earlier run and may not be overwritten, is in use, or cannot be written.
    pub fn record(&self, dir: &Path, overwrite: bool) -> Result<RunWriter> {
        let (scene, model) = (&self.scene, &self.model);
        let picture = if model.needs.stress { Scalar::Stress } else { Scalar::Displacement };
        let options = RecordingOptions {
            vtu: scene.record.vtu,
            arrays: scene.record.arrays.is_some(),
            moving: model.needs.dynamic,
            predicted: self.stepper.has_error_bound(),
            // A picture shows the pads.
            picture: (scene.record.pictures && !model.fingers.is_empty()).then_some(picture),
            overwrite,
            object_name: model.object.name.clone(),
            pads: model.fingers.iter().map(|f| f.placement.pose()).collect(),
            order: self.grasps.iter().map(|(number, _)| *number).collect(),
            ..RecordingOptions::default()
        };
        Ok(RunWriter::new(model, RunRecorder::create(dir, options, self.report()?)?))
    }

    /// Runs the grasps and judges them. `sense` also measures their sensitivity, at five times the work.
    ///
    /// # Errors
    /// Fails as [`run_grasps`] does, and if a file cannot be written.
    pub fn run(&self, writer: Option<RunWriter>, sense: bool, observer: &dyn Observer) -> Result<SimulationResult> {
        if sense {
            self.scene.gripper.require_equal_fingers("a sensitivity")?;
        }
        let last_frames = LastFrames::default();
        let recorded = writer.as_ref().map_or(&() as &dyn Observer, |writer| writer);
        let watched = (observer, recorded);
        let kept = (&watched as &dyn Observer, &last_frames as &dyn Observer);
        let observer: &dyn Observer = if sense { &kept } else { &watched };
        let clock = Instant::now();
        let stepper = self.stepper.as_ref();
        let mut outcomes = run_grasps(&self.model, stepper, &self.grasps, self.threads, observer)?;
        let wall_s = clock.elapsed().as_secs_f64();
        let mut recorder = writer.map(RunWriter::finish);
        if sense {
            let ends = FinalStates::of(&outcomes, last_frames);
            let answers = sensitivity(&self.scene, &self.model, stepper, (&self.grasps, &ends), self.threads)?;
            outcomes.iter_mut().zip(&answers).for_each(|(o, moved)| o.summary.sensitivity = moved.clone());
            recorder.iter_mut().for_each(|recorder| recorder.add_sensitivity(answers.clone()));
        }
        let measured: Vec<GraspMeasurements> = outcomes.iter().map(|o| o.measured.clone()).collect();
        let verdicts: Vec<Verdict> = self.scene.expectations().iter().map(|e| evaluate_all(e, &measured)).collect();
        let (expectations, profile) = (verdicts.iter().map(as_report).collect(), profile(&outcomes));
        let report = match recorder {
            Some(recorder) => recorder.finish(expectations, profile)?,
            None => {
                let mut report = self.report()?;
                report.grasps = outcomes.iter().map(|o| o.summary.clone()).collect();
                (report.expectations, report.profile_s, report.finished) = (expectations, profile, true);
                report
            }
        };
        Ok(SimulationResult { outcomes, verdicts, report, wall_s })
    }

    /// Returns the report of a run that has not begun.
    fn report(&self) -> Result<RunReport> {
        let value = serde_json::to_value(&self.scene)
            .map_err(|e| Error::Scene(format!("error: the scene cannot be written as JSON: {e}")))?;
        let backend = format!("{} ({})", self.stepper.name(), self.stepper.settings());
        let mut report = RunReport::new(backend, self.threads, value);
        report.pads = self.model.pad_reports();
        report.notices = self.notices.clone();
        report.expectations_source = self.scene.expectations_source().into();
        Ok(report)
    }
}

impl SimulationResult {
    /// Returns true if all expectations of the scene are met or, if it has none, if all grasps reached their load.
    pub fn succeeded(&self) -> bool {
        match self.verdicts.is_empty() {
            true => self.outcomes.iter().all(|o| o.summary.status == Status::Reached),
            false => self.verdicts.iter().all(|h| h.held),
        }
    }
}

/// Returns the wanted grasps with their numbers, in order and without repetition; all if none is wanted.
fn select(poses: &[Pose], wanted: &[usize]) -> Result<Vec<(usize, Pose)>> {
    let mut numbers: Vec<usize> = if wanted.is_empty() { (0..poses.len()).collect() } else { wanted.to_vec() };
    let mut seen = BTreeSet::new();
    numbers.retain(|number| seen.insert(*number));
    let pick = |i: usize| {
        poses.get(i).map(|p| (i, *p)).ok_or_else(|| {
            let last = poses.len().saturating_sub(1);
            Error::Argument(format!("--grasp {i}: the scene has {}, 0 to {last}", format_count(poses.len(), "grasp")))
        })
    };
    numbers.into_iter().map(pick).collect()
}

fn as_report(held: &Verdict) -> ExpectationReport {
    ExpectationReport { name: held.name.to_string(), held: held.held, value: held.value, bound: held.bound }
}

/// Returns the wall time by stage over all grasps, s.
fn profile(outcomes: &[Outcome]) -> BTreeMap<String, f64> {
    let mut sum = BTreeMap::new();
    for (stage, seconds) in outcomes.iter().flat_map(|o| &o.timings.stages) {
        *sum.entry(stage.to_string()).or_insert(0.0) += seconds;
    }
    sum
}
