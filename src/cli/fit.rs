//! Command `tactus fit`: fits the gel constants, the friction and the zero of depth of a press to a measured curve of
//! force against depth.

use super::console::Console;
use super::output::{EXIT_EXPECTATION_FAILED, EXIT_OK, Format};
use base::error::{Error, Result};
use base::files::atomic::{create_dir, write_atomic};
use base::machine::machine_threads;
use bench::fit::{self, Curve, Ranges, chart};
use indicatif::ProgressBar;
use scene::load_object;
use std::path::PathBuf;
use std::time::Duration;

/// Arguments of `tactus fit`.
#[derive(Debug, clap::Args)]
pub struct FitArgs {
    /// Scene file of a press; `-` is standard input.
    pub scene: PathBuf,
    /// Measured forces: CSV with the header `depth_m,force_n`.
    #[arg(long, value_name = "TABLE")]
    pub curve: PathBuf,
    /// Object to press if the scene has several.
    #[arg(long, value_name = "NAME")]
    pub object: Option<String>,
    /// Range of `young` (Pa), `poisson`, `friction` or `depth_zero` (m); the default is that of a tactile gel. May be
    /// given several times.
    #[arg(long, value_name = "NAME=LOW,HIGH", allow_hyphen_values = true)]
    pub range: Vec<String>,
    /// Number of threads; the default is all threads of the machine. Each press runs on one thread.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1024))]
    pub threads: Option<u64>,
    /// Folder for `fit.json`, `fit.png` and `fit.svg`; existing files are replaced.
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Format of the report on stdout.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Fits Young's modulus, Poisson's ratio, the friction coefficient and the zero of depth of the press in `args.scene`
/// to the curve in `args.curve`: alone, in pairs and all together, as far as the curve has enough points. Prints the
/// report to `console`, and writes it with its charts to `args.out` if given. Returns the exit code: 0 if every fit
/// converged, otherwise 1.
///
/// # Errors
/// Fails if the scene, the curve or a range is invalid, a press fails, the process is interrupted, or a file cannot be
/// written.
pub fn fit(args: &FitArgs, console: &dyn Console) -> Result<u8> {
    let loaded = load_object(&args.scene, args.object.as_deref())?;
    let curve = Curve::read(&args.curve)?;
    let mut ranges = Ranges::default();
    for text in &args.range {
        ranges.set(text).map_err(|m| Error::Argument(format!("--range {m}")))?;
    }
    let threads = args.threads.map_or_else(machine_threads, |n| n as usize);
    args.out.as_deref().map_or(Ok(()), create_dir)?;
    let bar = console.attach_progress_bar(ProgressBar::new_spinner());
    bar.enable_steady_tick(Duration::from_millis(200));
    let report = fit::fit(&loaded.scene, &curve, &ranges, threads, |text| bar.set_message(text.to_string()));
    bar.finish_and_clear();
    let report = report.map_err(|e| loaded.locate_error(e))?;
    let json = serde_json::to_string_pretty(&report)
        .map_err(|e| Error::Solver(format!("the report cannot be written as JSON: {e}")))?
        + "\n";
    if let Some(dir) = &args.out {
        write_atomic(&dir.join("fit.json"), json.as_bytes())?;
        chart::save_chart(&report, dir)?;
    }
    console.print(&if args.format == Format::Json { json } else { report.text() })?;
    Ok(if report.converged() { EXIT_OK } else { EXIT_EXPECTATION_FAILED })
}
