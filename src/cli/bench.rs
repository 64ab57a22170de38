//! `tactus bench`: speed against error of all settings and networks; or cost against size; or steps of a task a second.

use super::run::machine_threads;
use super::{Format, OK, print};
use crate::bench::contest::Rules;
use crate::bench::{chart, contest, cost_by_size, rollout, rollouts, sizes, table};
use crate::error::{Error, Result};
use crate::record::files::{create_dir, write_atomic};
use crate::scene::{load_object, load_set};
use indicatif::ProgressBar;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Arguments of `tactus bench`.
#[derive(Debug, clap::Args)]
pub struct BenchArgs {
    /// The scene file.
    pub scene: PathBuf,
    /// The object to take from a scene of several.
    #[arg(long, value_name = "NAME")]
    pub object: Option<String>,
    /// Grasps, evenly spread over those of the scene.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=10000))]
    pub grasps: u64,
    /// Recorded frames of each grasp, instead of the scene's.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10000))]
    pub frames: Option<u64>,
    /// Threads of each grasp; all that the machine has by default. Grasps run one at a time.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    pub threads: Option<u64>,
    /// Folder of a trained model to compare; may be given again.
    #[arg(long, value_name = "DIR")]
    pub model: Vec<PathBuf>,
    /// How often each configuration simulates each grasp, in turn; times are medians.
    #[arg(long, value_name = "R", default_value_t = 3, value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub repeat: u64,
    /// Instead: the cost of the first grasp with pads of about so many nodes each, separated by commas.
    #[arg(long, value_name = "N,...", value_delimiter = ',', conflicts_with_all = ["model", "grasps"],
          value_parser = clap::value_parser!(u64).range(8..=1_000_000))]
    pub sizes: Vec<u64>,
    /// Instead: steps of a task a second with so many environments each, separated by commas, on 1, 2, 4 ... threads, on the
    /// scene's backend and each model.
    #[arg(long, value_name = "N,...", value_delimiter = ',', conflicts_with_all = ["sizes", "grasps", "frames", "object"],
          value_parser = clap::value_parser!(u64).range(1..=100_000))]
    pub envs: Vec<u64>,
    /// Folder for `bench.json`, `bench.csv`, `bench.png` and `bench.svg` (`sizes.json` with `--sizes`; `envs.json`, `envs.png`
    /// and `envs.svg` with `--envs`); replaces those there.
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Form of the report on stdout.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Measures, prints, and writes what is asked for.
pub fn bench(args: &BenchArgs) -> Result<ExitCode> {
    let bar = ProgressBar::new_spinner();
    bar.enable_steady_tick(Duration::from_millis(200));
    let progress = |text: &str| bar.set_message(text.to_string());
    args.out.as_deref().map_or(Ok(()), create_dir)?;
    let measured = if args.envs.is_empty() { measure(args, progress) } else { play(args, progress) };
    bar.finish_and_clear();
    let (text, json) = measured?;
    print(if args.format == Format::Json { &json } else { &text })?;
    Ok(ExitCode::from(OK))
}

/// Steps of a task a second: the report as text and as JSON; files are written.
fn play(args: &BenchArgs, progress: impl FnMut(&str)) -> Result<(String, String)> {
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

/// Speed against error, or cost against size: the report as text and as JSON; files are written.
fn measure(args: &BenchArgs, progress: impl FnMut(&str)) -> Result<(String, String)> {
    let loaded = load_object(&args.scene, args.object.as_deref())?;
    let mut scene = loaded.scene.clone();
    if let Some(frames) = args.frames {
        scene.loading.set_frames(frames).map_err(|m| Error::Scene(format!("error: {m}")))?;
    }
    let threads = args.threads.map_or_else(machine_threads, |n| n as usize);
    let repeats = args.repeat as usize;
    let out = args.out.as_deref();
    if !args.sizes.is_empty() {
        let wanted: Vec<usize> = args.sizes.iter().map(|n| *n as usize).collect();
        let report = cost_by_size(&scene, &wanted, threads, repeats, progress).map_err(|e| loaded.place(e))?;
        let json = as_json(&report)?;
        out.map_or(Ok(()), |dir| write_atomic(&dir.join("sizes.json"), json.as_bytes()))?;
        return Ok((sizes::text(&report), json));
    }
    let rules = Rules { grasps: args.grasps as usize, threads, repeats };
    let report = contest(&scene, &args.model, &rules, progress).map_err(|e| loaded.place(e))?;
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
