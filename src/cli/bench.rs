//! Command `tactus bench`: error against time of all settings and networks, cost against mesh size, or environment
//! steps per second.

use super::console::Console;
use super::output::{EXIT_OK, Format};
use base::error::{Error, Result};
use base::files::atomic::{create_dir, write_atomic};
use base::machine::machine_threads;
use bench::certify::References;
use bench::comparison::ComparisonSettings;
use bench::{certify, chart, compare, cost_by_size, refinement_study, rollout, rollouts, sizes, table};
use indicatif::ProgressBar;
use scene::{Scene, load_object, load_set};
use serde::Serialize;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `tactus bench`.
#[derive(Debug, clap::Args)]
pub struct BenchArgs {
    /// Scene file; `-` is standard input.
    pub scene: PathBuf,
    /// Object to measure if the scene has several.
    #[arg(long, value_name = "NAME")]
    pub object: Option<String>,
    /// Number of grasps, evenly spread over those of the scene.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=10000))]
    pub grasps: u64,
    /// Number of recorded frames of each grasp; overrides the scene.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10000))]
    pub frames: Option<u64>,
    /// Number of threads of each grasp; the default is all threads of the machine. Grasps run one at a time.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    pub threads: Option<u64>,
    /// Folder of a trained model to include; may be given several times.
    #[arg(long, value_name = "DIR")]
    pub model: Vec<PathBuf>,
    /// Number of repetitions of each grasp by each configuration; times are medians.
    #[arg(long, value_name = "R", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub repeat: u64,
    /// Number of meshes in the refinement sequence from which the error of the reference is estimated. The first has
    /// the cell size of the scene, and each further one is finer by the square root of two.
    #[arg(long, value_name = "N", default_value_t = refinement_study::DEFAULT_LEVELS as u64, value_parser = clap::value_parser!(u64).range(2..=6))]
    pub rungs: u64,
    /// Instead, compute reference values of the first grasp of each object with error estimates, into `references.json`
    /// and `references.md`; rows of other objects in these files are kept.
    #[arg(long, conflicts_with_all = ["model", "grasps", "sizes", "envs"])]
    pub certify: bool,
    /// Instead, measure the cost of the first grasp against the mesh size, with pads of about N nodes each; several N
    /// are separated by commas.
    #[arg(long, value_name = "N,...", value_delimiter = ',', conflicts_with_all = ["model", "grasps"],
          value_parser = clap::value_parser!(u64).range(8..=1_000_000))]
    pub sizes: Vec<u64>,
    /// Instead, measure the steps per second of the scene's task with N parallel environments (several N are separated
    /// by commas) on 1, 2, 4 ... threads, with the backend of the scene and with each model.
    #[arg(long, value_name = "N,...", value_delimiter = ',', conflicts_with_all = ["sizes", "grasps", "frames", "object"],
          value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub envs: Vec<u64>,
    /// Folder for `bench.json`, `bench.csv`, `bench.png` and `bench.svg` (`sizes.json` with `--sizes`; `envs.json`,
    /// `envs.png` and `envs.svg` with `--envs`); existing files are replaced.
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Format of the report on stdout.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Runs the requested measurement, and prints and writes its report.
///
/// # Errors
/// Fails if an argument is invalid, the measurement fails or a file cannot be written.
pub fn bench(args: &BenchArgs, console: &dyn Console) -> Result<u8> {
    let bar = console.attach_progress_bar(ProgressBar::new_spinner());
    bar.enable_steady_tick(Duration::from_millis(200));
    let progress = |text: &str| bar.set_message(text.to_string());
    args.out.as_deref().map_or(Ok(()), create_dir)?;
    let measured = match (args.certify, args.envs.is_empty()) {
        (true, _) => references(args, progress),
        (false, true) => measure(args, progress),
        (false, false) => measure_rollouts(args, progress),
    };
    bar.finish_and_clear();
    let (text, json) = measured?;
    console.print(if args.format == Format::Json { &json } else { &text })?;
    Ok(EXIT_OK)
}

/// Computes references with error estimates. Returns the rows as text and as JSON; the files are written after each
/// row.
fn references(args: &BenchArgs, mut progress: impl FnMut(&str)) -> Result<(String, String)> {
    let set = load_set(&args.scene)?.retain_object(args.object.as_deref())?;
    let settings = comparison_settings(args);
    let mut all = args.out.as_deref().map_or_else(|| Ok(References::default()), References::read)?;
    let (mut own, mut studies) = (References::default(), String::new());
    for named in &set.scenes {
        let mut named = named.clone();
        set_frames(args, &mut named.scene)?;
        let (row, study) =
            certify(&named, &args.scene, &settings, &mut progress).map_err(|e| set.locate_error(e, &named.name))?;
        studies += &format!("\n{}{}", row.name, table::refinement_text(&study));
        own.put(row.clone());
        all.put(row);
        if let Some(dir) = args.out.as_deref() {
            write_atomic(&dir.join("references.json"), as_json(&all)?.as_bytes())?;
            write_atomic(&dir.join("references.md"), all.markdown().as_bytes())?;
        }
    }
    Ok((format!("{}{studies}", own.markdown()), as_json(&own)?))
}

fn comparison_settings(args: &BenchArgs) -> ComparisonSettings {
    ComparisonSettings {
        grasps: args.grasps as usize,
        threads: args.threads.map_or_else(machine_threads, |n| n as usize),
        repeats: args.repeat as usize,
        levels: args.rungs as usize,
    }
}

/// Applies `--frames`.
fn set_frames(args: &BenchArgs, scene: &mut Scene) -> Result<()> {
    args.frames.map_or(Ok(()), |frames| scene.loading.set_frames(frames).map_err(Error::Argument))
}

/// Measures the steps of a task per second. Returns the report as text and as JSON, and writes the files.
fn measure_rollouts(args: &BenchArgs, progress: impl FnMut(&str)) -> Result<(String, String)> {
    let set = load_set(&args.scene)?.scenes;
    let envs: Vec<usize> = args.envs.iter().map(|n| *n as usize).collect();
    let most = args.threads.map_or_else(machine_threads, |n| n as usize);
    let threads: Vec<usize> =
        std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|n| *n < most).chain([most]).collect();
    let report = rollouts(&set, &args.model, &envs, &threads, args.repeat as usize, progress)?;
    let json = as_json(&report)?;
    if let Some(dir) = args.out.as_deref() {
        write_atomic(&dir.join("envs.json"), json.as_bytes())?;
        rollout::save_chart(&report, dir)?;
    }
    Ok((rollout::text(&report), json))
}

/// Measures speed against error, or cost against mesh size. Returns the report as text and as JSON, and writes the
/// files.
fn measure(args: &BenchArgs, progress: impl FnMut(&str)) -> Result<(String, String)> {
    let loaded = load_object(&args.scene, args.object.as_deref())?;
    let mut scene = loaded.scene.clone();
    set_frames(args, &mut scene)?;
    let settings = comparison_settings(args);
    let out = args.out.as_deref();
    if !args.sizes.is_empty() {
        let wanted: Vec<usize> = args.sizes.iter().map(|n| *n as usize).collect();
        let report = cost_by_size(&scene, &wanted, settings.threads, settings.repeats, progress)
            .map_err(|e| loaded.locate_error(e))?;
        let json = as_json(&report)?;
        out.map_or(Ok(()), |dir| write_atomic(&dir.join("sizes.json"), json.as_bytes()))?;
        return Ok((sizes::text(&report), json));
    }
    let report = compare(&scene, &args.model, &settings, progress).map_err(|e| loaded.locate_error(e))?;
    let json = as_json(&report)?;
    if let Some(dir) = out {
        write_atomic(&dir.join("bench.json"), json.as_bytes())?;
        write_atomic(&dir.join("bench.csv"), table::csv(&report).as_bytes())?;
        chart::save_chart(&report, dir)?;
    }
    Ok((table::text(&report), json))
}

fn as_json(report: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string_pretty(report);
    text.map(|t| t + "\n").map_err(|e| Error::Solver(format!("the report cannot be written as JSON: {e}")))
}
