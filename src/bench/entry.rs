//! Entry of a comparison: a configuration, its simulations, and their times and errors.

use super::clock::{peak_memory, processor_time, reset_peak_memory};
use super::refinement_study;
use super::sweep::Configuration;
use backend::choose;
use base::error::Result;
use base::interrupt;
use base::stats::median;
use geometry::Pose;
use model::Model;
use record::error_norm::{FieldInterpolation, Fields, FrameDistance, Points};
use record::{Frame, Status};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use world::Stepper;
use world::environment::Environment;
use world::run::{Observer, Outcome, run_grasp};

/// Configuration with its results.
#[derive(Debug)]
pub struct BenchEntry {
    /// Configuration of the entry.
    pub configuration: Configuration,
    /// Model and backend; None while they are not loaded.
    pub prepared: Option<PreparedConfiguration>,
    /// Wall time of the set-up and of the first simulation after it, s.
    pub cold_s: f64,
    /// Wall time of each repetition by grasp, s, without the time for recording frames.
    pub wall_s: BTreeMap<usize, Vec<f64>>,
    /// Processor time of all threads by grasp, s.
    pub processor_s: BTreeMap<usize, Vec<f64>>,
    /// Wall time by stage, all repetitions, s.
    pub stages: BTreeMap<&'static str, f64>,
    /// Number of Newton iterations or decoder passes, all repetitions.
    pub iterations: u64,
    /// Number of frames, all repetitions.
    pub frames: usize,
    /// Largest resident memory of the process with this configuration alone, up to its first frame, bytes.
    pub peak_memory: Option<u64>,
    /// Errors, one per grasp and frame from a fifth of the load on.
    pub errors: Vec<FrameDistance>,
    /// Grasps that did not reach their load, with the reason.
    pub failed: Vec<String>,
}

/// Configuration with its loaded model and backend.
#[derive(Debug)]
pub struct PreparedConfiguration {
    /// Model of its scene.
    pub model: Arc<Model>,
    /// Backend of the configuration.
    pub stepper: Box<dyn Stepper>,
    probe: FieldInterpolation,
    setup_s: f64,
}

/// Observer that keeps the frames of a grasp.
#[derive(Default)]
struct FrameCollector(Mutex<Vec<Frame>>);

impl Observer for FrameCollector {
    fn frame(&self, _index: usize, frame: &Frame) -> Result<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(frame.clone());
        Ok(())
    }
}

impl BenchEntry {
    pub(super) fn new(configuration: Configuration) -> Self {
        Self {
            configuration,
            prepared: None,
            cold_s: f64::NAN,
            wall_s: BTreeMap::new(),
            processor_s: BTreeMap::new(),
            stages: BTreeMap::new(),
            iterations: 0,
            frames: 0,
            peak_memory: None,
            errors: Vec::new(),
            failed: Vec::new(),
        }
    }

    /// Measures the peak memory of a simulation up to the first frame, while no other configuration is loaded.
    pub(super) fn measure_memory(&mut self, pose: Pose) -> Result<()> {
        let known = reset_peak_memory();
        let scene = &self.configuration.scene;
        let (model, stepper) = (Model::build(scene)?, choose(scene)?);
        let mut environment = Environment::new(&model, stepper.as_ref(), pose)?;
        while environment.frame().is_none() && !environment.step().is_final() {}
        interrupt::check()?;
        self.peak_memory = peak_memory().filter(|_| known);
        Ok(())
    }

    /// Simulates a grasp on `pool`; returns the fields of its frames at the first repetition, otherwise or on failure
    /// nothing.
    pub(super) fn run(
        &mut self,
        pool: &rayon::ThreadPool,
        index: usize,
        pose: Pose,
        points: &Points,
    ) -> Result<Vec<Fields>> {
        let frames = self.simulate(pool, index, pose, points)?;
        Ok(self.fields(&frames))
    }

    /// Returns the fields of frames.
    pub(super) fn fields(&self, frames: &[Frame]) -> Vec<Fields> {
        let probe = self.prepared.as_ref().map(|p| &p.probe);
        probe.map_or_else(Vec::new, |probe| frames.iter().map(|f| probe.fields(f)).collect())
    }

    /// Simulates a grasp on `pool`; returns its frames at the first repetition, otherwise or on failure nothing.
    pub(super) fn simulate(
        &mut self,
        pool: &rayon::ThreadPool,
        index: usize,
        pose: Pose,
        points: &Points,
    ) -> Result<Vec<Frame>> {
        let first = !self.wall_s.contains_key(&index);
        let (cold, prepared) = match self.prepared.take() {
            Some(prepared) => (false, self.prepared.insert(prepared)),
            None => (true, self.prepared.insert(PreparedConfiguration::new(&self.configuration, points, pose)?)),
        };
        let (keep, before) = (FrameCollector::default(), processor_time());
        let outcome = pool.install(|| run_grasp(&prepared.model, prepared.stepper.as_ref(), index, pose, &keep))?;
        let processor = processor_time().zip(before).map(|(now, before)| now - before);
        let wall = outcome.summary.wall_s - outcome.timings.stages.get("record").copied().unwrap_or(0.0);
        if cold {
            self.cold_s = prepared.setup_s + wall;
        }
        if outcome.summary.status != Status::Reached {
            if first {
                self.wall_s.insert(index, Vec::new());
                self.failed.push(format!("grasp {index}: {}", outcome.summary.reason.unwrap_or_default()));
            }
            return Ok(Vec::new());
        }
        self.wall_s.entry(index).or_default().push(wall);
        self.processor_s.entry(index).or_default().extend(processor);
        self.iterations += outcome.timings.iterations;
        self.frames += outcome.summary.frames;
        add_stages(&mut self.stages, &outcome);
        let frames = keep.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(if first { frames } else { Vec::new() })
    }

    /// Adds the errors of the frames of a grasp against those of the reference; either list may be empty.
    pub(super) fn add_errors(&mut self, points: &Points, own: &[Fields], truth: &[Fields]) {
        if let Some(prepared) = &self.prepared {
            self.errors.extend(refinement_study::distances(points, &prepared.model.levels, own, truth));
        }
    }

    /// Returns the wall time of a grasp, s: median over the repetitions, then over the grasps.
    pub fn time_per_grasp(&self) -> f64 {
        medians(&self.wall_s)
    }

    /// Returns the processor time of a grasp, s: median over the repetitions, then over the grasps.
    pub fn processor_time_per_grasp(&self) -> Option<f64> {
        Some(medians(&self.processor_s)).filter(|t| t.is_finite())
    }
}

fn medians(turns: &BTreeMap<usize, Vec<f64>>) -> f64 {
    median(turns.values().filter(|t| !t.is_empty()).map(|t| median(t.iter().copied())))
}

/// Adds the time by stage of a grasp, without the time for recording frames, which only the bench needs.
pub fn add_stages(stages: &mut BTreeMap<&'static str, f64>, outcome: &Outcome) {
    for (stage, seconds) in outcome.timings.stages.iter().filter(|(stage, _)| **stage != "record") {
        *stages.entry(stage).or_insert(0.0) += seconds;
    }
}

impl PreparedConfiguration {
    fn new(configuration: &Configuration, points: &Points, pose: Pose) -> Result<Self> {
        let clock = Instant::now();
        let (mut model, stepper) = (Model::build(&configuration.scene)?, choose(&configuration.scene)?);
        if let Some(model) = Arc::get_mut(&mut model) {
            // Smallest det F and gap of predictions are not used here.
            model.needs.shape = false;
        }
        // Cached data of the pads are loaded once, as part of the set-up.
        drop(Environment::new(&model, stepper.as_ref(), pose)?);
        let setup_s = clock.elapsed().as_secs_f64();
        let probe = FieldInterpolation::new(points, &model.fingers[0].topology);
        Ok(Self { model, stepper, probe, setup_s })
    }
}
