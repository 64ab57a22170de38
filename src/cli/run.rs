//! Command `tactus run`: simulates the grasps of a scene.

use super::console::Console;
use super::output::{EXIT_EXPECTATION_FAILED, EXIT_OK, Format, with_kept_note};
use super::progress::RunProgress;
use super::table;
use super::watch::{WatchArgs, folder, run_watched};
use backend::simulate::Simulation;
use base::error::{Error, Result};
use scene::{Backend, LoadedSet, Overrides, Scene, load_set};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Arguments of `tactus run`.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct RunArgs {
    /// Scene file; `-` is standard input.
    pub scene: PathBuf,
    /// Object to simulate if the scene has several; the default is all of them, one after the other, each into
    /// `DIR/NAME`.
    #[arg(long, value_name = "NAME")]
    pub object: Option<String>,
    /// Folder for the results; without it no files are written.
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the results of an earlier run in the folder instead of failing.
    #[arg(long, requires = "out")]
    pub overwrite: bool,
    /// Format of the report on stdout.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Number of threads; overrides the scene.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    pub threads: Option<u64>,
    /// Time limit of a grasp in wall-clock seconds; a grasp that exceeds it ends with the status `fault`. Results then
    /// depend on the speed of the machine.
    #[arg(long, value_name = "SECONDS")]
    pub max_time: Option<f64>,
    /// Run only the grasp with this number, from 0; may be given several times.
    #[arg(long, value_name = "I")]
    pub grasp: Vec<usize>,
    /// Final force of a squeeze, the sum over the fingers, N; overrides the scene.
    #[arg(long, value_name = "N")]
    pub force: Option<f64>,
    /// Number of recorded frames; overrides the scene.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10000))]
    pub frames: Option<u64>,
    /// Also measure the sensitivity of each grasp: the change of pads and object under small changes of friction, of
    /// the pose of the hand and of the force at which the object is released; five times the work.
    #[arg(long)]
    pub sensitivity: bool,
    /// Write no pictures.
    #[arg(long)]
    pub no_pictures: bool,
    /// Backend; overrides the scene.
    #[arg(long, value_enum)]
    pub backend: Option<Backend>,
    /// Folder of the trained model for `--backend gnn`; the default is `universe`, which is part of tactus.
    #[arg(long, value_name = "MODEL", requires = "backend")]
    pub model: Option<PathBuf>,
    /// Largest accepted error of the displacement predicted by a network, relative, like 0.05; a grasp whose predicted
    /// error exceeds it is computed by finite elements.
    #[arg(long, value_name = "PART")]
    pub error_at_most: Option<f64>,
    /// Allow predictions outside the range of the training data, where their error is unknown.
    #[arg(long)]
    pub extrapolate: bool,
    /// Options of the page in the browser.
    #[command(flatten)]
    pub watch: WatchArgs,
}

impl RunArgs {
    /// Loads the scenes of all objects, or of the requested one, with the arguments applied.
    ///
    /// # Errors
    /// Fails if the scene file or an argument is invalid, or no object has the requested name.
    pub fn load(&self) -> Result<LoadedSet> {
        let mut set = load_set(&self.scene)?.retain_object(self.object.as_deref())?;
        let overrides = Overrides {
            backend: self.backend,
            model: self.model.clone(),
            error_at_most: self.error_at_most,
            extrapolate: self.extrapolate,
            force: self.force,
            frames: self.frames,
            threads: self.threads,
            max_time: self.max_time,
            no_pictures: self.no_pictures,
        };
        set.scenes.iter_mut().try_for_each(|named| overrides.apply(&mut named.scene))?;
        if self.sensitivity {
            set.require_equal_pads("a sensitivity")?;
        }
        Ok(set)
    }
}

/// Returns the error of an invalid argument.
pub(super) fn argument_error(message: &str) -> Error {
    Error::Argument(message.into())
}

/// Simulates, records and reports the grasps of the scene, one object after the other. If there are several objects,
/// each has a subfolder of its name in the folder of the results.
///
/// # Errors
/// Fails if the scene or an argument is invalid, a model cannot be built, or a file cannot be written.
pub fn run(args: &RunArgs, console: &dyn Console) -> Result<u8> {
    let set = args.load()?;
    if !args.watch.watch {
        return run_set(args, &set, console);
    }
    let (out, _kept) = folder(args.out.as_deref())?;
    let args = RunArgs { out: Some(out.clone()), ..args.clone() };
    run_watched(&args.watch, &out, console, || run_set(&args, &set, console))
}

fn run_set(args: &RunArgs, set: &LoadedSet, console: &dyn Console) -> Result<u8> {
    let (several, mut good, mut reports) = (set.scenes.len() > 1, true, Vec::new());
    for named in &set.scenes {
        let name = named.name.as_str();
        let out = args.out.as_ref().map(|dir| if several { dir.join(name) } else { dir.clone() });
        let (text, held) = run_object(args, &named.scene, out.as_deref(), console.ends_process() && !several, console)
            .map_err(|e| set.locate_error(e, &named.name))
            .map_err(|e| if several { with_object_name(name, &e) } else { e })?;
        good &= held;
        match args.format {
            Format::Text if several => console.print(&format!("object {name}\n{text}\n"))?,
            Format::Json if several => reports.push(with_name(name, &text)?),
            _ => console.print(&text)?,
        }
    }
    if several && args.format == Format::Json {
        console.print(&format!("{:#}\n", json!({ "objects": reports })))?;
    }
    Ok(if good { EXIT_OK } else { EXIT_EXPECTATION_FAILED })
}

/// Returns the error with the name of the object that it concerns.
pub(super) fn with_object_name(name: &str, error: &Error) -> Error {
    let text = error.to_string();
    Error::Scene(format!("error: object {name}: {}", text.strip_prefix("error: ").unwrap_or(&text)))
}

/// Returns a JSON report with the name of its object added.
fn with_name(name: &str, text: &str) -> Result<Value> {
    let mut report: Value = serde_json::from_str(text)
        .map_err(|e| argument_error(&format!("the report of {name} is not valid JSON: {e}")))?;
    report["name"] = json!(name);
    Ok(report)
}

/// Simulates the grasps of one object into `out`. Returns the report, and true if all expectations hold. If `last`, the
/// process ends next, and memory is not freed.
fn run_object(
    args: &RunArgs,
    scene: &Scene,
    out: Option<&Path>,
    last: bool,
    console: &dyn Console,
) -> Result<(String, bool)> {
    let simulation = Simulation::new(scene, &args.grasp, args.threads.map(|n| n as usize))?;
    let writer = out.map(|dir| simulation.record(dir, args.overwrite)).transpose()?;
    let held = writer.as_ref().and_then(|writer| writer.notice());
    simulation.notices.iter().chain(&held).for_each(|notice| console.warn(&format!("note: {notice}")));
    let (grasps, frames) = (simulation.grasps.len(), simulation.model.levels.len());
    let watch = RunProgress::new(console, grasps, frames);
    let simulated = simulation.run(writer, args.sensitivity, &watch);
    let ended = watch.finish();
    let simulated = simulated.map_err(|error| {
        with_kept_note(error, || {
            let place = args.out.as_ref().map_or_else(String::new, |dir| format!(" in {}", dir.display()));
            format!("{ended} of {grasps} grasps are finished{place}")
        })
    })?;
    let text = match args.format {
        Format::Json => simulated.report.to_json().map_err(Error::Solver)?,
        Format::Text => table::render(scene, &simulation.grasps, &simulated),
    };
    let good = simulated.succeeded();
    if last {
        std::mem::forget((simulation, simulated));
    }
    Ok((text, good))
}

/// Starts a pool of threads.
pub(super) fn pool(threads: usize) -> Result<rayon::ThreadPool> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| Error::Start(format!("cannot start {threads} threads: {e}")))
}
