//! Command `tactus report`: writes results as one self-contained HTML page.

use super::console::Console;
use super::output::{EXIT_OK, Format};
use base::error::Result;
use base::files::atomic::{create_dir, write_atomic};
use report::{DEFAULT_FRAMES, ReportOptions, report};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `tactus report`.
#[derive(Debug, clap::Args)]
pub struct ReportArgs {
    /// Folders of runs, data sets, trainings and benches; all are shown on one page.
    #[arg(required = true)]
    pub dirs: Vec<PathBuf>,
    /// Folder of a trained model to evaluate on the data sets.
    #[arg(long, value_name = "DIR")]
    pub model: Option<PathBuf>,
    /// Test grasps: `poses`, `all`, `single:OBJECT` or `without:OBJECT`; the default is the split on which the model
    /// was trained.
    #[arg(long)]
    pub split: Option<String>,
    /// Number of grasps of each folder shown in 3-D; with a model, 1 shows the median grasp, 2 the median and the
    /// worst, and more are spread from best to worst.
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub grasps: usize,
    /// Largest number of frames of each grasp, evenly spread.
    #[arg(long, value_name = "N", default_value_t = DEFAULT_FRAMES as u64, value_parser = clap::value_parser!(u64).range(1..=10000))]
    pub frames: u64,
    /// Output file.
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    pub out: PathBuf,
    /// Format of the output on stdout: the tables as Markdown, or a JSON object with the path of the page.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Writes the page and prints its tables.
///
/// # Errors
/// Fails if a folder has no readable results, the model cannot be evaluated, or the page cannot be written.
pub fn report_page(args: &ReportArgs, console: &dyn Console) -> Result<u8> {
    let wishes = ReportOptions {
        model: args.model.clone(),
        split: args.split.clone(),
        grasps: args.grasps,
        frames: args.frames as usize,
    };
    let page = report(&args.dirs, &wishes)?;
    let html = page.html()?;
    if let Some(dir) = args.out.parent().filter(|dir| !dir.as_os_str().is_empty()) {
        create_dir(dir)?;
    }
    write_atomic(&args.out, html.as_bytes())?;
    let grasps: Vec<&str> = page.recordings.iter().map(|r| r.name.as_str()).collect();
    let text = match args.format {
        Format::Text => {
            let megabytes = html.len() as f64 / 1e6;
            format!("{}{}: {megabytes:.1} MB, grasps in 3-D: {}\n", page.markdown(), args.out.display(), grasps.len())
        }
        Format::Json => format!("{}\n", json!({ "page": args.out, "bytes": html.len(), "grasps": grasps })),
    };
    console.print(&text)?;
    Ok(EXIT_OK)
}
