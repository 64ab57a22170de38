//! Command `tactus dataset`: simulates all grasps of all objects of a scene into a folder; and `tactus dataset
//! inspect`.

use super::console::Console;
use super::dataset_table::{dataset_text, sensitivity_text};
use super::inspect;
use super::output::{EXIT_EXPECTATION_FAILED, EXIT_OK, Format, with_kept_note};
use super::run::argument_error;
use super::watch::{WatchArgs, run_watched};
use base::error::Result;
use base::machine::machine_threads;
use base::number::format_count;
use dataset::manifest::ExcludedObject;
use dataset::progress::FinishedGrasp;
use dataset::{Campaign, DatasetObserver, Selection};
use geometry::Pose;
use indicatif::{ProgressBar, ProgressStyle};
use model::grasp::keep_first;
use net::infer::predict::Predictor;
use net::infer::predicted_errors::predicted_errors;
use record::Status;
use scene::overrides::limit_time;
use scene::{GraspCount, NamedScene, Scene, load_seeded};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Largest number of objects whose notices are printed; the manifest lists all.
const MAX_NOTICES: usize = 50;

/// Arguments of `tactus dataset`.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct DatasetArgs {
    /// Command to run instead of making a data set.
    #[command(subcommand)]
    pub command: Option<DatasetCommand>,
    /// Scene file, which may list several objects; `-` is standard input.
    #[arg(required = true)]
    pub scene: Option<PathBuf>,
    /// Folder of the data set; an unfinished data set is resumed.
    #[arg(short, long, value_name = "DIR", required = true)]
    pub out: Option<PathBuf>,
    /// Format of the report on stdout.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// Number of threads; the default is all threads of the machine. The files do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    pub threads: Option<u64>,
    /// Simulate only this object; may be given several times.
    #[arg(long, value_name = "NAME")]
    pub object: Vec<String>,
    /// Simulate only the first N grasps of each object.
    #[arg(long, value_name = "N")]
    pub grasps: Option<u64>,
    /// Number of recorded frames of each grasp; overrides the scene.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10000))]
    pub frames: Option<u64>,
    /// Seed of the random objects of a universe; overrides the scene.
    #[arg(long, value_name = "SEED")]
    pub seed: Option<u64>,
    /// Simulate only the grasps with the largest predicted errors of this trained model: a quarter of all, or the
    /// number given by `--keep`.
    #[arg(long, value_name = "MODEL")]
    pub worst_of: Option<PathBuf>,
    /// Number of grasps to simulate with `--worst-of`.
    #[arg(long, value_name = "N", requires = "worst_of", value_parser = clap::value_parser!(u64).range(1..))]
    pub keep: Option<u64>,
    /// Time limit of a grasp in wall-clock seconds; a grasp that exceeds it ends with the status `fault`. The files
    /// then depend on the speed of the machine.
    #[arg(long, value_name = "SECONDS")]
    pub max_time: Option<f64>,
    /// Simulate only part I of N, from 1 to N. Parts may run at the same time, on several machines that share the
    /// folder; the same command without this option then completes the data set.
    #[arg(long, value_name = "I/N", value_parser = parse_part)]
    pub part: Option<(usize, usize)>,
    /// Also measure the sensitivity of the first N grasps of each object (like `run --sensitivity`) into
    /// `sensitivity.csv`; this adds five times the work for these grasps.
    #[arg(long, value_name = "N", conflicts_with = "part", value_parser = clap::value_parser!(u64).range(1..))]
    pub sensitivity: Option<u64>,
    /// Print the content and the size of the data set, and stop.
    #[arg(long, conflicts_with = "watch")]
    pub dry_run: bool,
    /// Options of the page in the browser.
    #[command(flatten)]
    pub watch: WatchArgs,
}

/// Subcommands for data sets.
#[derive(Debug, clap::Subcommand)]
pub enum DatasetCommand {
    /// Check a data set, print its counts, ranges and histograms, and draw pictures.
    Inspect(inspect::InspectArgs),
}

/// Creates a data set.
///
/// # Errors
/// Fails if the scene or an argument is invalid, the folder is in use, or a file cannot be written.
pub fn dataset(args: &DatasetArgs, console: &dyn Console) -> Result<u8> {
    if let Some(DatasetCommand::Inspect(args)) = &args.command {
        return inspect::inspect(args, console);
    }
    let (Some(scene), Some(out)) = (&args.scene, &args.out) else {
        return Err(argument_error("a scene and `-o DIR` are needed"));
    };
    run_watched(&args.watch, out, console, || create_dataset(args, scene, out, console))
}

fn create_dataset(args: &DatasetArgs, scene: &Path, out: &Path, console: &dyn Console) -> Result<u8> {
    let mut set = load_seeded(scene, args.seed)?;
    choose(&mut set.scenes, &args.object)?;
    limit(&mut set.scenes, args.grasps, args.frames)?;
    if let Some(seconds) = args.max_time {
        set.scenes.iter_mut().try_for_each(|s| limit_time(&mut s.scene.stepper, seconds))?;
    }
    if args.sensitivity.is_some() {
        set.require_equal_pads("a sensitivity")?;
    }
    let threads = args.threads.map_or_else(machine_threads, |n| n as usize);
    let predictor = args.worst_of.as_deref().map(Predictor::open).transpose()?;
    let score = |scene: &Scene, poses: &[Pose]| match &predictor {
        Some(predictor) => predicted_errors(predictor, scene, poses),
        None => Ok(vec![0.0; poses.len()]),
    };
    let keep = args.keep.map(|keep| keep as usize);
    let selection = predictor.is_some().then_some(Selection { keep, score: &score });
    let mut campaign = Campaign::plan_selected(&set, out, backend::choose, selection.as_ref())?;
    let manifest = campaign.manifest();
    let resumed = campaign.finished();
    console.print_message(&format!(
        "{}, {} of {}; at most {:.1} MB in {}{}",
        format_count(manifest.objects.len(), "object"),
        format_count(manifest.grasps, "grasp"),
        format_count(manifest.frames, "frame"),
        campaign.bytes() as f64 / 1e6,
        out.display(),
        if resumed > 0 { format!("; {resumed} grasps are already finished") } else { String::new() },
    ));
    for ExcludedObject { name, reason } in manifest.left_out.iter().take(MAX_NOTICES) {
        console.warn(&format!("{name}: omitted: {reason}"));
    }
    for object in manifest.objects.iter().take(MAX_NOTICES) {
        object.notices.iter().for_each(|notice| console.warn(&format!("{}: {notice}", object.name)));
    }
    if args.dry_run {
        return Ok(EXIT_OK);
    }
    let (bytes, grasps) = (campaign.bytes(), manifest.grasps);
    let (own, there) = match args.part {
        None => (grasps, resumed),
        Some((part, parts)) => (manifest.sum(|o| (o.grasps + parts - part) / parts), 0),
    };
    let bar = Bar::new(console, own, there, manifest.frames);
    let clock = Instant::now();
    if let Some((part, parts)) = args.part {
        let ran = campaign.run_part(part - 1, parts, threads, &bar);
        bar.bar.finish_and_clear();
        let ran = ran.map_err(|error| {
            with_kept_note(error, || {
                let ended = bar.ended.load(Ordering::Relaxed);
                format!(
                    "{ended} grasps of this part are finished in {}; the same command resumes from there",
                    out.display()
                )
            })
        })?;
        let text = match args.format {
            Format::Text => {
                format!(
                    "part {part} of {parts}: {}; run the command without --part to complete the data set\n",
                    format_count(ran, "grasp")
                )
            }
            Format::Json => format!("{}\n", json!({ "part": part, "parts": parts, "computed": ran, "dir": out })),
        };
        console.print(&text)?;
        return Ok(EXIT_OK);
    }
    let manifest = campaign.run(threads, &bar);
    bar.bar.finish_and_clear();
    let manifest = manifest.map_err(|error| {
        with_kept_note(error, || {
            let ended = bar.ended.load(Ordering::Relaxed);
            format!("{ended} of {grasps} grasps are finished in {}; the same command resumes from there", out.display())
        })
    })?;
    let wall = clock.elapsed().as_secs_f64();
    let spreads = match args.sensitivity {
        Some(most) => campaign.sensitivity(most as usize, threads)?,
        None => Vec::new(),
    };
    let text = match args.format {
        Format::Text => dataset_text(&manifest, resumed, wall) + &sensitivity_text(&spreads),
        Format::Json => {
            let object = json!({
                "manifest": manifest, "resumed": resumed, "computed": grasps - resumed, "announced_bytes": bytes,
                "wall_s": wall, "dir": out, "sensitivity": spreads,
            });
            format!("{object}\n")
        }
    };
    console.print(&text)?;
    let all = manifest.sum(|o| o.reached) == manifest.grasps;
    let kept = manifest.objects.iter().flat_map(|o| &o.expectations).all(|p| p.worst.held);
    Ok(if all && kept { EXIT_OK } else { EXIT_EXPECTATION_FAILED })
}

/// Parses `I/N`.
fn parse_part(text: &str) -> std::result::Result<(usize, usize), String> {
    let numbers = text.split_once('/').and_then(|(i, n)| i.parse().ok().zip(n.parse().ok()));
    let inside = numbers.filter(|(i, n): &(usize, usize)| (1..=*n).contains(i));
    inside.ok_or_else(|| "allowed: I/N with I from 1 to N, like 2/8".into())
}

/// Applies `--grasps` and `--frames` to all objects.
pub(super) fn limit(scenes: &mut [NamedScene], grasps: Option<u64>, frames: Option<u64>) -> Result<()> {
    if let Some(most) = grasps {
        let most = GraspCount::new(most).map_err(|m| argument_error(&format!("--grasps {m}")))?;
        scenes.iter_mut().try_for_each(|s| keep_first(&mut s.scene.grasps, most))?;
    }
    if let Some(frames) = frames {
        scenes.iter_mut().try_for_each(|s| s.scene.loading.set_frames(frames)).map_err(|m| argument_error(&m))?;
    }
    Ok(())
}

/// Keeps the objects with the `wanted` names, or all if none is given.
fn choose(scenes: &mut Vec<NamedScene>, wanted: &[String]) -> Result<()> {
    let names: Vec<_> = scenes.iter().map(|s| s.name.as_str().to_string()).collect();
    if let Some(unknown) = wanted.iter().find(|w| !names.contains(w)) {
        return Err(argument_error(&format!("--object {unknown}: the scene has {}", names.join(", "))));
    }
    scenes.retain(|s| wanted.is_empty() || wanted.iter().any(|w| w == s.name.as_str()));
    Ok(())
}

/// Progress bar on stderr: frames, rate, time left, failures.
struct Bar<'a> {
    console: &'a dyn Console,
    bar: ProgressBar,
    grasps: usize,
    frames: usize,
    ended: AtomicUsize,
    failed: AtomicUsize,
}

impl<'a> Bar<'a> {
    fn new(console: &'a dyn Console, grasps: usize, resumed: usize, frames: usize) -> Self {
        let bar = console.attach_progress_bar(ProgressBar::new(((grasps - resumed) * frames) as u64));
        // The template is a constant; if it were invalid, the default style would be used.
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {msg}  {per_sec} frames  {elapsed}, {eta} left") {
            bar.set_style(style);
        }
        Self { console, bar, grasps, frames, ended: AtomicUsize::new(resumed), failed: AtomicUsize::new(0) }
    }
}

impl DatasetObserver for Bar<'_> {
    fn frame(&self) {
        self.bar.inc(1);
    }

    fn grasp(&self, object: &str, finished: &FinishedGrasp) {
        self.bar.inc(self.frames.saturating_sub(finished.frames) as u64);
        let ended = self.ended.fetch_add(1, Ordering::Relaxed) + 1;
        let failed = usize::from(finished.status != Status::Reached);
        let failed = self.failed.fetch_add(failed, Ordering::Relaxed) + failed;
        self.bar.set_message(format!("{object}: grasp {ended}/{}, {failed} failed", self.grasps));
    }

    fn notice(&self, notice: &str) {
        self.console.warn(&format!("note: {notice}"));
    }
}
