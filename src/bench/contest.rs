//! Comparison of all configurations on the same grasps. Repetitions are interleaved, so that other load on the machine
//! affects all configurations alike.

use super::clock::{peak_memory, processor_time, reset_peak_memory};
use super::ladder::{self, Member, RefinementStudy, Role, Tally};
use super::report::BenchReport;
use super::sweep::{Configuration, Sweep};
use super::values::{FrameValues, values};
use backend::choose;
use base::error::{Error, Result};
use base::interrupt;
use base::stats::median;
use geometry::Pose;
use model::Model;
use model::grasp::poses_of;
use record::error_norm::{Distance, FieldInterpolation, Fields, Points};
use record::{Frame, Status};
use scene::Scene;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;
use world::Stepper;
use world::environment::Environment;
use world::run::{Observer, Outcome, run_grasp};

/// Settings of a comparison.
#[derive(Debug, Clone, Copy)]
pub struct Rules {
    /// Number of grasps, evenly spread over those of the scene; all if there are fewer.
    pub grasps: usize,
    /// Number of threads of each grasp; grasps run one at a time.
    pub threads: usize,
    /// Number of repetitions of each grasp by each configuration; times are medians.
    pub repeats: usize,
    /// Number of levels of the mesh refinement sequence from which the error of the reference is estimated.
    pub rungs: usize,
}

/// Configuration with its results.
#[derive(Debug)]
pub struct BenchEntry {
    /// Configuration of the entry.
    pub configuration: Configuration,
    /// Model and backend; None while they are not loaded.
    pub prepared: Option<Prepared>,
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
    pub errors: Vec<Distance>,
    /// Grasps that did not reach their load, with the reason.
    pub failed: Vec<String>,
}

/// Configuration with its loaded model and backend.
#[derive(Debug)]
pub struct Prepared {
    /// Model of its scene.
    pub model: Arc<Model>,
    /// Backend of the configuration.
    pub stepper: Box<dyn Stepper>,
    probe: FieldInterpolation,
    setup_s: f64,
}

/// Observer that keeps the frames of a grasp.
#[derive(Default)]
struct Keep(Mutex<Vec<Frame>>);

impl Observer for Keep {
    fn frame(&self, _index: usize, frame: &Frame) -> Result<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(frame.clone());
        Ok(())
    }
}

/// Compares the settings around those of `scene` and the networks in `models`; `progress` is called for every
/// simulation.
///
/// # Errors
/// Fails if the scene is not supported by a bench or cannot be built, a network rejects it, or the reference completes
/// no grasp.
pub fn contest(
    scene: &Scene,
    models: &[PathBuf],
    rules: &Rules,
    mut progress: impl FnMut(&str),
) -> Result<BenchReport> {
    let sweep = Sweep::new(scene)?;
    let mut climb = RefinementRun::new(&sweep, rules)?;
    let mut entries: Vec<BenchEntry> = sweep.configurations(models)?.into_iter().map(BenchEntry::new).collect();
    let mut grasps = sample(&poses_of(scene)?, rules.grasps);
    if let Some((_, pose)) = grasps.first() {
        // In order of size, because memory that the allocator keeps from one configuration is reused by the next.
        let mut all: Vec<&mut BenchEntry> = entries.iter_mut().chain([climb.reference()]).collect();
        all.sort_by_key(|e| e.configuration.nodes);
        for entry in all {
            progress(&format!("memory: {}", entry.configuration.label));
            entry.measure_memory(*pose)?;
        }
    }
    for turn in 0..rules.repeats {
        let mut lost = Vec::new();
        for (index, pose) in &grasps {
            let mut truth = Vec::new();
            if turn == 0 {
                match climb.grasp(*index, *pose, &mut progress)?.into_iter().find(|s| s.role == Role::Reference) {
                    Some(step) => truth = step.fields,
                    None => {
                        lost.push(*index);
                        continue;
                    }
                }
            }
            for entry in &mut entries {
                progress(&format!(
                    "repetition {} of {}, grasp {index}: {}",
                    turn + 1,
                    rules.repeats,
                    entry.configuration.label
                ));
                let own = entry.run(&climb.pool, *index, *pose, &climb.points)?;
                entry.judge(&climb.points, &own, &truth);
            }
        }
        grasps.retain(|(index, _)| !lost.contains(index));
    }
    if grasps.is_empty() {
        return Err(Error::Solver(format!("the reference failed for all grasps: {}", climb.notices.join("; "))));
    }
    let numbers = grasps.iter().map(|(index, _)| *index).collect();
    let (ladder, notices) = (climb.ladder(), std::mem::take(&mut climb.notices));
    Ok(BenchReport::new(rules, numbers, (climb.reference(), ladder), &entries, notices))
}

/// Result of a member of the mesh refinement study for a grasp.
#[derive(Debug)]
pub struct MemberResult {
    /// Role of the member.
    pub role: Role,
    /// Fields of its frames at the common points; empty if it failed.
    pub fields: Vec<Fields>,
    /// Values of its last frame.
    pub values: FrameValues,
}

/// Members of the mesh refinement study, with their distances accumulated over the grasps.
#[derive(Debug)]
pub struct RefinementRun {
    members: Vec<(Role, BenchEntry)>,
    reference: usize,
    tally: Tally,
    /// Points at which fields are compared.
    pub points: Points,
    /// Thread pool in which grasps run.
    pub pool: rayon::ThreadPool,
    /// Notices of failed grasps, with the reason.
    pub notices: Vec<String>,
}

impl RefinementRun {
    /// Creates the mesh refinement study for the scene of a sweep.
    ///
    /// # Errors
    /// Fails if a pad cannot be meshed or threads cannot be started.
    pub fn new(sweep: &Sweep, rules: &Rules) -> Result<Self> {
        let members: Vec<_> =
            ladder::members(sweep, rules.rungs)?.into_iter().map(|(role, c)| (role, BenchEntry::new(c))).collect();
        let reference = members.iter().position(|(role, _)| *role == Role::Reference).unwrap_or(0);
        // Quadrature points of the mesh one level below the reference: it resolves the edge of a contact patch with an
        // affordable number of points.
        let (_, sampled) = &members[reference.saturating_sub(1)];
        let points = Points::of(&Model::build(&sampled.configuration.scene)?.finger()?.topology);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(rules.threads)
            .build()
            .map_err(|e| Error::Start(format!("cannot start {} threads: {e}", rules.threads)))?;
        Ok(Self { tally: Tally::new(members.len()), reference, members, points, pool, notices: Vec::new() })
    }

    /// Returns the reference.
    pub fn reference(&mut self) -> &mut BenchEntry {
        &mut self.members[self.reference].1
    }

    /// Simulates a grasp with all members. If the reference fails, the result is empty. Every member that fails adds a
    /// notice and is omitted from the result.
    ///
    /// # Errors
    /// Fails if the grasp cannot be run.
    pub fn grasp(&mut self, index: usize, pose: Pose, progress: &mut impl FnMut(&str)) -> Result<Vec<MemberResult>> {
        let (mut steps, mut levels) = (Vec::new(), Vec::new());
        for (role, entry) in &mut self.members {
            progress(&format!("grasp {index}: {}", entry.configuration.label));
            let frames = entry.simulate(&self.pool, index, pose, &self.points)?;
            let model = entry.prepared.as_ref().map(|p| p.model.clone());
            let last = model.as_ref().zip(frames.last());
            let values = last.map_or_else(FrameValues::new, |(model, frame)| values(model, frame));
            steps.push(MemberResult { role: *role, fields: entry.fields(&frames), values });
            if let Some(reason) = entry.failed.pop() {
                let whose = if *role == Role::Reference {
                    "the reference; the grasp is omitted"
                } else {
                    &entry.configuration.label
                };
                self.notices.push(format!("{reason} in {whose}"));
            }
            levels = model.map_or(levels, |m| m.levels.clone());
            if *role != Role::Reference {
                // Released because it is large and not needed before the next grasp.
                entry.prepared = None;
            }
        }
        let fails = |s: &MemberResult| s.fields.is_empty();
        if steps.iter().any(|s| s.role == Role::Reference && fails(s)) {
            return Ok(Vec::new());
        }
        let fields: Vec<&[Fields]> = steps.iter().map(|s| &s.fields[..]).collect();
        self.tally.add(&self.points, &levels, &fields);
        steps.retain(|s| !fails(s));
        Ok(steps)
    }

    /// Returns the results of the mesh refinement study for the grasps so far.
    pub fn ladder(&self) -> RefinementStudy {
        let member = |(role, entry): &(Role, BenchEntry)| Member {
            label: entry.configuration.label.clone(),
            role: *role,
            nodes: entry.configuration.nodes,
            time_per_grasp_s: Some(entry.time_per_grasp()).filter(|t| t.is_finite()),
        };
        RefinementStudy::new(self.members.iter().map(member).collect(), &self.tally)
    }
}

/// Returns evenly spread grasps with their numbers.
fn sample(poses: &[Pose], wanted: usize) -> Vec<(usize, Pose)> {
    let count = wanted.clamp(1, poses.len().max(1));
    let numbers = (0..count).map(|i| i * poses.len() / count);
    numbers.filter_map(|i| poses.get(i).map(|p| (i, *p))).collect()
}

impl BenchEntry {
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

    /// Measures the peak memory of a simulation up to the first frame, while no other configuration is loaded.
    fn measure_memory(&mut self, pose: Pose) -> Result<()> {
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
    fn run(&mut self, pool: &rayon::ThreadPool, index: usize, pose: Pose, points: &Points) -> Result<Vec<Fields>> {
        let frames = self.simulate(pool, index, pose, points)?;
        Ok(self.fields(&frames))
    }

    /// Returns the fields of frames.
    fn fields(&self, frames: &[Frame]) -> Vec<Fields> {
        let probe = self.prepared.as_ref().map(|p| &p.probe);
        probe.map_or_else(Vec::new, |probe| frames.iter().map(|f| probe.fields(f)).collect())
    }

    /// Simulates a grasp on `pool`; returns its frames at the first repetition, otherwise or on failure nothing.
    fn simulate(&mut self, pool: &rayon::ThreadPool, index: usize, pose: Pose, points: &Points) -> Result<Vec<Frame>> {
        let first = !self.wall_s.contains_key(&index);
        let (cold, prepared) = match self.prepared.take() {
            Some(prepared) => (false, self.prepared.insert(prepared)),
            None => (true, self.prepared.insert(Prepared::new(&self.configuration, points, pose)?)),
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
        Ok(if first { frames } else { Vec::new() })
    }

    /// Adds the errors of the frames of a grasp against those of the reference; either list may be empty.
    fn judge(&mut self, points: &Points, own: &[Fields], truth: &[Fields]) {
        if let Some(prepared) = &self.prepared {
            self.errors.extend(ladder::distances(points, &prepared.model.levels, own, truth));
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

impl Prepared {
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
