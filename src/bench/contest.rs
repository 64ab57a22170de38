//! All configurations over the same grasps, taking turns, so that a busy machine slows them alike.

use super::clock::{forget_peak_memory, peak_memory, processor_time};
use super::error::FrameError;
use super::probe::{Fields, Points, Probe};
use super::report::Report;
use super::spread::median;
use super::sweep::{Configuration, Sweep};
use crate::environment::Environment;
use crate::error::{Error, Result};
use crate::gnn::eval::table::FROM_LOAD;
use crate::grasp::{GraspPose, poses_of};
use crate::interrupt;
use crate::model::{Model, pad};
use crate::record::{Frame, Status};
use crate::runner::{Observer, Outcome, run_grasp};
use crate::scene::Scene;
use crate::stepper::{Stepper, choose};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// How a contest is held.
#[derive(Debug, Clone, Copy)]
pub struct Rules {
    /// Grasps, evenly spread over those of the scene; all if there are fewer.
    pub grasps: usize,
    /// Threads of each grasp; grasps run one at a time.
    pub threads: usize,
    /// How often each configuration simulates each grasp; times are medians.
    pub repeats: usize,
}

/// One configuration and what it did.
#[derive(Debug)]
pub struct Entry {
    /// What it is.
    pub configuration: Configuration,
    /// What is needed to run it, once its first turn has come.
    pub prepared: Option<Prepared>,
    /// Wall time to get ready and to simulate the first grasp for the first time, s.
    pub cold_s: f64,
    /// Per grasp: wall time of each turn, s; what keeping frames for the comparison takes is left out.
    pub wall_s: BTreeMap<usize, Vec<f64>>,
    /// Per grasp: processor time of all threads, s.
    pub processor_s: BTreeMap<usize, Vec<f64>>,
    /// Wall time by stage, all turns, s.
    pub stages: BTreeMap<&'static str, f64>,
    /// Newton iterations or decoder passes, all turns.
    pub iterations: u64,
    /// Frames, all turns.
    pub frames: usize,
    /// Largest resident memory of the process with this configuration alone, up to its first frame, bytes.
    pub peak_memory: Option<u64>,
    /// One per grasp and frame above a fifth of the load.
    pub errors: Vec<FrameError>,
    /// Grasps that did not get there, and why.
    pub failed: Vec<String>,
}

/// A configuration ready to run.
#[derive(Debug)]
pub struct Prepared {
    /// Its scene, built.
    pub model: Arc<Model>,
    /// Its backend.
    pub stepper: Box<dyn Stepper>,
    probe: Probe,
    setup_s: f64,
}

/// Keeps the frames of a grasp.
#[derive(Default)]
struct Keep(Mutex<Vec<Frame>>);

impl Observer for Keep {
    fn frame(&self, _index: usize, frame: &Frame) -> Result<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(frame.clone());
        Ok(())
    }
}

/// Lets the settings around those of `scene` and the networks in `models` compete; `progress` hears of every turn.
///
/// # Errors
/// A scene that cannot be compared or built, a network that refuses it, a reference that reaches the end of no grasp.
pub fn contest(scene: &Scene, models: &[PathBuf], rules: &Rules, mut progress: impl FnMut(&str)) -> Result<Report> {
    let sweep = Sweep::new(scene)?;
    let mut reference = Entry::new(sweep.reference()?);
    let mut entries: Vec<Entry> = sweep.configurations(models)?.into_iter().map(Entry::new).collect();
    let points = Points::of(&pad::build(&scene.gripper.pads, &mut Vec::new())?.0.mesh);
    let mut grasps = sample(&poses_of(scene)?, rules.grasps);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(rules.threads)
        .build()
        .map_err(|e| Error::Start(format!("cannot start {} threads: {e}", rules.threads)))?;
    if let Some((_, pose)) = grasps.first() {
        // From small to large: what the allocator keeps of one serves the next.
        let mut all: Vec<&mut Entry> = entries.iter_mut().chain([&mut reference]).collect();
        all.sort_by_key(|e| e.configuration.nodes);
        for entry in all {
            progress(&format!("memory: {}", entry.configuration.label));
            entry.measure_memory(*pose)?;
        }
    }
    let mut notices = Vec::new();
    for turn in 0..rules.repeats {
        let mut lost = Vec::new();
        for (index, pose) in &grasps {
            let mut truth = Vec::new();
            if turn == 0 {
                progress(&format!("grasp {index}: {}", reference.configuration.label));
                truth = reference.run(&pool, *index, *pose, &points)?;
                if let Some(reason) = reference.failed.pop() {
                    notices.push(format!("{reason} in the reference: left out"));
                    lost.push(*index);
                    continue;
                }
            }
            for entry in &mut entries {
                progress(&format!(
                    "turn {} of {}, grasp {index}: {}",
                    turn + 1,
                    rules.repeats,
                    entry.configuration.label
                ));
                let own = entry.run(&pool, *index, *pose, &points)?;
                entry.judge(&points, &own, &truth);
            }
        }
        grasps.retain(|(index, _)| !lost.contains(index));
    }
    if grasps.is_empty() {
        return Err(Error::Solver(format!("there is nothing to compare with: {}", notices.join("; "))));
    }
    let numbers = grasps.iter().map(|(index, _)| *index).collect();
    Ok(Report::new(rules, numbers, &reference, &entries, notices))
}

/// Evenly spread grasps with their numbers.
fn sample(poses: &[GraspPose], wanted: usize) -> Vec<(usize, GraspPose)> {
    let count = wanted.clamp(1, poses.len().max(1));
    let numbers = (0..count).map(|i| i * poses.len() / count);
    numbers.filter_map(|i| poses.get(i).map(|p| (i, *p))).collect()
}

impl Entry {
    fn new(configuration: Configuration) -> Self {
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

    /// Simulates up to the first frame, with nothing else of the contest loaded.
    fn measure_memory(&mut self, pose: GraspPose) -> Result<()> {
        let known = forget_peak_memory();
        let scene = &self.configuration.scene;
        let (model, stepper) = (Model::build(scene)?, choose(scene)?);
        let mut environment = Environment::new(&model, stepper.as_ref(), pose)?;
        while environment.frame().is_none() && !environment.step().is_final() {}
        interrupt::check()?;
        self.peak_memory = peak_memory().filter(|_| known);
        Ok(())
    }

    /// Simulates a grasp on `pool`; the fields of its frames if this is the first time, nothing if it fails.
    fn run(&mut self, pool: &rayon::ThreadPool, index: usize, pose: GraspPose, points: &Points) -> Result<Vec<Fields>> {
        let first = !self.wall_s.contains_key(&index);
        let (cold, prepared) = match self.prepared.take() {
            Some(prepared) => (false, self.prepared.insert(prepared)),
            None => (true, self.prepared.insert(Prepared::new(&self.configuration, points)?)),
        };
        let (keep, before) = (Keep::default(), processor_time());
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
        let Some(prepared) = self.prepared.as_ref().filter(|_| first) else { return Ok(Vec::new()) };
        Ok(frames.iter().map(|f| prepared.probe.fields(f)).collect())
    }

    /// Compares the frames of a grasp with those of the reference, both whole or empty.
    fn judge(&mut self, points: &Points, own: &[Fields], truth: &[Fields]) {
        let Some(levels) = self.prepared.as_ref().map(|p| &p.model.levels) else { return };
        let last = levels.last().copied().unwrap_or(1.0);
        // Next to nothing is deformed at a small load, and relative errors say little there.
        for ((own, truth), level) in own.iter().zip(truth).zip(levels) {
            if *level >= (FROM_LOAD - 1e-9) * last {
                self.errors.push(FrameError::of(points, own, truth));
            }
        }
    }

    /// Wall time of a grasp, s: median over the turns, then over the grasps.
    pub fn time_per_grasp(&self) -> f64 {
        medians(&self.wall_s)
    }

    /// The same of the processor time, s.
    pub fn processor_time_per_grasp(&self) -> Option<f64> {
        Some(medians(&self.processor_s)).filter(|t| t.is_finite())
    }
}

fn medians(turns: &BTreeMap<usize, Vec<f64>>) -> f64 {
    median(turns.values().filter(|t| !t.is_empty()).map(|t| median(t.iter().copied())))
}

/// Adds where a grasp spent its time; keeping frames is the bench's own doing.
pub fn add_stages(stages: &mut BTreeMap<&'static str, f64>, outcome: &Outcome) {
    for (stage, seconds) in outcome.timings.stages.iter().filter(|(stage, _)| **stage != "record") {
        *stages.entry(stage).or_insert(0.0) += seconds;
    }
}

impl Prepared {
    fn new(configuration: &Configuration, points: &Points) -> Result<Self> {
        let clock = Instant::now();
        let (model, stepper) = (Model::build(&configuration.scene)?, choose(&configuration.scene)?);
        let setup_s = clock.elapsed().as_secs_f64();
        let probe = Probe::new(points, &model.fingers[0].topology);
        Ok(Self { model, stepper, probe, setup_s })
    }
}
