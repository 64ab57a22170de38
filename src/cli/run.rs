//! Command `tactus run`: simulates the grasps of a scene.

use super::watch::Watch;
use super::{Format, NOT_HELD, OK, kept, print, say, table};
use crate::backend::choose;
use crate::error::{Error, Result};
use crate::grasp::{aim_notice, poses_of};
use crate::gripper::GraspPose;
use crate::judge::{Measured, Verdict, evaluate_all};
use crate::model::Model;
use crate::net::SHIPPED;
use crate::part::FingerModel;
use crate::record::{ExpectationReport, RunReport, Status};
use crate::render::Scalar;
use crate::run::sensitivity::{Ends, LastFrames, sensitivity};
use crate::run::{Observer, Outcome, run_grasps};
use crate::run::{Options, RunRecorder};
use crate::scene::leaf::{Count, Positive};
use crate::scene::recheck;
use crate::scene::{Condensed, Fem, Gnn, LoadedSet, Scene, Solver, StepperChoice, load_set};
use crate::world::Stepper;
use clap::ValueEnum;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Arguments of `tactus run`.
#[derive(Debug, clap::Args)]
pub struct RunArgs {
    /// Scene file.
    pub scene: PathBuf,
    /// Object to take from a scene with several; without it all run, one after the other, into `DIR/NAME`.
    #[arg(long, value_name = "NAME")]
    pub object: Option<String>,
    /// Folder for the results; without it nothing is written.
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace an earlier run in the folder instead of refusing.
    #[arg(long, requires = "out")]
    pub overwrite: bool,
    /// Form of the report on stdout.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Number of threads, instead of the scene's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    pub threads: Option<u64>,
    /// Wall time that a grasp may take, s; a longer one ends as a fault. Which grasps end then depends on the machine.
    #[arg(long, value_name = "SECONDS")]
    pub max_time: Option<f64>,
    /// Run only this grasp of the scene (from 0); may be given several times.
    #[arg(long, value_name = "I")]
    pub grasp: Vec<usize>,
    /// Number of recorded frames, instead of the scene's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10000))]
    pub frames: Option<u64>,
    /// Also measure how far pads and object move if friction, the pose of the hand and the force at which the object is released change
    /// slightly: five times the work.
    #[arg(long)]
    pub sensitivity: bool,
    /// Draw no pictures.
    #[arg(long)]
    pub no_pictures: bool,
    /// Backend, instead of the scene's.
    #[arg(long, value_enum)]
    pub backend: Option<Backend>,
    /// Folder of the trained model, for `--backend gnn`; the default is the one that ships with tactus, `universe`.
    #[arg(long, value_name = "MODEL", requires = "backend")]
    pub model: Option<PathBuf>,
    /// Largest error of the displacement that is accepted from a network, like 0.05; grasps of which it is not sure go to finite elements.
    #[arg(long, value_name = "PART")]
    pub error_at_most: Option<f64>,
    /// Let a network answer outside the range of its training, with a wider interval of the error.
    #[arg(long)]
    pub extrapolate: bool,
}

/// Backend that advances the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// Finite elements.
    Fem,
    /// Finite elements with pads condensed onto the nodes that touch: fast, with an error.
    Condensed,
    /// Trained network.
    Gnn,
}

impl RunArgs {
    /// Loads the scenes of all objects, or of the requested one, with the arguments applied.
    ///
    /// # Errors
    /// Fails if the scene file or an argument is refused, or no object has the requested name.
    pub fn load(&self) -> Result<LoadedSet> {
        let mut set = load_set(&self.scene)?.only(self.object.as_deref())?;
        set.scenes.iter_mut().try_for_each(|named| self.change(&mut named.scene))?;
        Ok(set)
    }

    /// Applies the arguments to a scene.
    fn change(&self, scene: &mut Scene) -> Result<()> {
        match (self.backend, &scene.stepper) {
            (Some(Backend::Fem | Backend::Condensed), stepper) => {
                let mut fem = if let StepperChoice::Fem(fem) = stepper { *fem } else { Fem::default() };
                fem.solver = match (self.backend, fem.solver) {
                    (Some(Backend::Fem), _) => Solver::Full,
                    (_, Solver::Full) => Solver::Condensed(Condensed::default()),
                    (_, given) => given,
                };
                scene.stepper = StepperChoice::Fem(fem);
            }
            (Some(Backend::Gnn), StepperChoice::Fem(_)) => {
                let model = self.model.clone().unwrap_or_else(|| SHIPPED.into());
                scene.stepper = StepperChoice::Gnn(Gnn::new(model));
            }
            _ => {}
        }
        self.trust(&mut scene.stepper)?;
        if let Some(threads) = self.threads {
            let threads = Count::new(threads).map_err(|m| refused(&format!("--threads {m}")))?;
            if let StepperChoice::Fem(Fem { threads: own, .. }) = &mut scene.stepper {
                *own = Some(threads);
            }
        }
        if let Some(seconds) = self.max_time {
            limit_time(&mut scene.stepper, seconds)?;
        }
        if let Some(frames) = self.frames {
            scene.loading.set_frames(frames).map_err(|m| refused(&m))?;
        }
        if self.no_pictures {
            scene.record.pictures = false;
        }
        recheck(scene)
    }
}

impl RunArgs {
    /// Applies what says how far a network is trusted.
    fn trust(&self, stepper: &mut StepperChoice) -> Result<()> {
        match stepper {
            StepperChoice::Gnn(gnn) => {
                let most = self.error_at_most.map(Positive::new).transpose();
                let most = most.map_err(|m| refused(&format!("--error-at-most {m}")))?;
                gnn.error_at_most = most.or(gnn.error_at_most);
                gnn.extrapolate |= self.extrapolate;
                Ok(())
            }
            StepperChoice::Fem(_) if self.error_at_most.is_some() || self.extrapolate => {
                Err(refused("--error-at-most and --extrapolate are for a network; add --backend gnn"))
            }
            StepperChoice::Fem(_) => Ok(()),
        }
    }
}

/// Applies `--max-time`.
pub(super) fn limit_time(stepper: &mut StepperChoice, seconds: f64) -> Result<()> {
    let seconds = Positive::new(seconds).map_err(|m| refused(&format!("--max-time {m}")))?;
    match stepper {
        StepperChoice::Fem(fem) => fem.max_time = Some(seconds),
        StepperChoice::Gnn(_) => {
            return Err(refused("--max-time is for finite elements: a network takes the same time for every grasp"));
        }
    }
    Ok(())
}

/// Returns the error of a refused argument.
pub(super) fn refused(message: &str) -> Error {
    Error::Scene(format!("error: {message}"))
}

/// Simulates the grasps of the scene, of one object after the other, records and reports them. If there are several
/// objects, each has a folder of its own name in the folder of the results.
///
/// # Errors
/// Fails if the scene or an argument is refused, a model cannot be built, or a file cannot be written.
pub fn run(args: &RunArgs) -> Result<ExitCode> {
    let set = args.load()?;
    let (several, mut good, mut reports) = (set.scenes.len() > 1, true, Vec::new());
    for named in &set.scenes {
        let name = named.name.as_str();
        let out = args.out.as_ref().map(|dir| if several { dir.join(name) } else { dir.clone() });
        let (text, held) = run_object(args, &named.scene, out.as_deref(), !several)
            .map_err(|e| set.place(e, &named.name))
            .map_err(|e| if several { about_object(name, &e) } else { e })?;
        good &= held;
        match args.format {
            Format::Text if several => print(&format!("object {name}\n{text}\n"))?,
            Format::Json if several => reports.push(with_name(name, &text)?),
            _ => print(&text)?,
        }
    }
    if several && args.format == Format::Json {
        print(&format!("{:#}\n", json!({ "objects": reports })))?;
    }
    Ok(ExitCode::from(if good { OK } else { NOT_HELD }))
}

/// Returns an error with the object that it is about.
pub(super) fn about_object(name: &str, error: &Error) -> Error {
    let text = error.to_string();
    Error::Scene(format!("error: object {name}: {}", text.strip_prefix("error: ").unwrap_or(&text)))
}

/// Returns a report as JSON, with the name of its object.
fn with_name(name: &str, text: &str) -> Result<Value> {
    let mut report: Value =
        serde_json::from_str(text).map_err(|e| refused(&format!("the report of {name} is no JSON: {e}")))?;
    report["name"] = json!(name);
    Ok(report)
}

/// Simulates the grasps of one object into `out`: returns the report, and true if all promises are kept. `last` is true if nothing
/// follows.
fn run_object(args: &RunArgs, scene: &Scene, out: Option<&Path>, last: bool) -> Result<(String, bool)> {
    // A network takes as long to read as the pads to mesh.
    let (stepper, model) = std::thread::scope(|scope| {
        let model = scope.spawn(|| Model::build(scene));
        (choose(scene), model.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    });
    let (stepper, model) = (stepper?, model?);
    let poses = poses_of(scene)?;
    let pad = model.fingers.first().map(FingerModel::bounds);
    let aim = pad.and_then(|pad| aim_notice(scene, &model.object, pad, &poses));
    let grasps = select(&poses, &args.grasp)?;
    let threads = args.threads.map_or_else(|| threads(scene), |n| n as usize);
    let value =
        serde_json::to_value(scene).map_err(|e| refused(&format!("the scene cannot be written as JSON: {e}")))?;
    let mut report = RunReport::new(format!("{} ({})", stepper.name(), stepper.settings()), threads, value);
    report.pads = model.pad_reports();
    report.promised_in = scene.promised_in().into();
    let recorder = match out {
        Some(dir) => Some(RunRecorder::create(dir, options(args, scene, &model, stepper.as_ref()), report.clone())?),
        None => None,
    };
    for notice in model.notices.iter().chain(&model.pad_notice).chain(&aim) {
        say(&format!("note: {notice}"));
    }
    let watch = Watch::new(&model, recorder, grasps.len());
    let clock = Instant::now();
    let last_frames = LastFrames::default();
    let both = (&watch, &last_frames);
    let observer: &dyn Observer = if args.sensitivity { &both } else { &watch };
    let outcomes = run_grasps(&model, stepper.as_ref(), &grasps, threads, observer);
    let ended = watch.ended();
    let mut recorder = watch.finish();
    let mut outcomes = outcomes.map_err(|error| {
        kept(error, || {
            let place = args.out.as_ref().map_or_else(String::new, |dir| format!(" in {}", dir.display()));
            format!("{ended} of {} grasps are finished{place}", grasps.len())
        })
    })?;
    let wall = clock.elapsed().as_secs_f64();
    if args.sensitivity {
        let ends = Ends::of(&outcomes, last_frames);
        let answers = sensitivity(scene, &model, stepper.as_ref(), (&grasps, &ends), threads)?;
        outcomes.iter_mut().zip(&answers).for_each(|(o, moved)| o.summary.sensitivity = moved.clone());
        recorder.iter_mut().for_each(|recorder| recorder.add_sensitivity(answers.clone()));
    }

    let measured: Vec<Measured> = outcomes.iter().map(|o| o.measured.clone()).collect();
    let held: Vec<Verdict> = scene.promises().iter().map(|e| evaluate_all(e, &measured)).collect();
    let expectations: Vec<ExpectationReport> = held.iter().map(as_report).collect();
    let profile = profile(&outcomes);
    let report = match recorder {
        Some(recorder) => recorder.finish(expectations, profile)?,
        None => {
            report.grasps = outcomes.iter().map(|o| o.summary.clone()).collect();
            (report.expectations, report.profile_s, report.finished) = (expectations, profile, true);
            report
        }
    };
    let text = match args.format {
        Format::Json => report.to_json().map_err(Error::Solver)?,
        Format::Text => table::render(scene, &grasps, &outcomes, &held, &report, wall),
    };
    let good = match held.is_empty() {
        true => outcomes.iter().all(|o| o.summary.status == Status::Reached),
        false => held.iter().all(|h| h.held),
    };
    if last {
        // The process ends: the system takes its memory back faster than it is given back piece by piece.
        std::mem::forget((model, stepper, outcomes));
    }
    Ok((text, good))
}

/// Returns the grasps to run, with their numbers; all if none is requested.
fn select(poses: &[GraspPose], wanted: &[usize]) -> Result<Vec<(usize, GraspPose)>> {
    let mut numbers: Vec<usize> = if wanted.is_empty() { (0..poses.len()).collect() } else { wanted.to_vec() };
    numbers.sort_unstable();
    numbers.dedup();
    let pick = |i: usize| {
        poses.get(i).map(|p| (i, *p)).ok_or_else(|| {
            refused(&format!(
                "--grasp {i}: the scene has {} grasps, 0 to {}",
                poses.len(),
                poses.len().saturating_sub(1)
            ))
        })
    };
    numbers.into_iter().map(pick).collect()
}

/// Returns the threads of the scene, otherwise all that the machine has.
fn threads(scene: &Scene) -> usize {
    let own = match &scene.stepper {
        StepperChoice::Fem(fem) => fem.threads.map(|t| t.get()),
        StepperChoice::Gnn(_) => None,
    };
    own.unwrap_or_else(machine_threads)
}

/// Returns the number of threads that the machine has.
pub(super) fn machine_threads() -> usize {
    std::thread::available_parallelism().map_or(1, |n| n.get())
}

/// Starts threads for parallel work.
pub(super) fn pool(threads: usize) -> Result<rayon::ThreadPool> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| Error::Start(format!("cannot start {threads} threads: {e}")))
}

/// Returns the output options, as the scene asks.
fn options(args: &RunArgs, scene: &Scene, model: &Model, stepper: &dyn Stepper) -> Options {
    let picture = if model.needs.stress { Scalar::Stress } else { Scalar::Displacement };
    Options {
        vtu: scene.record.vtu,
        arrays: scene.record.arrays.is_some(),
        moving: model.needs.dynamic,
        predicted: stepper.knows_error(),
        // The picture is of the pads.
        picture: (scene.record.pictures && !model.fingers.is_empty()).then_some(picture),
        overwrite: args.overwrite,
        object_name: model.object.name.clone(),
        pads: model.fingers.iter().map(|f| f.placement.pose()).collect(),
        ..Options::default()
    }
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
