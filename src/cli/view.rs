//! Command `tactus view`: a page in the browser that shows results while they are written.

use super::console::Console;
use super::output::{EXIT_OK, Format};
use super::run::{RunArgs, argument_error, run};
use super::watch::{DEFAULT_GRASPS, folder, open_browser};
use base::error::{Error, Result};
use base::files::lock::is_held;
use report::view::Viewer;
use report::{DEFAULT_FRAMES, ReportOptions, holds_results};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `tactus view`.
#[derive(Debug, clap::Args)]
pub struct ViewArgs {
    /// Folder of a run, data set, training or bench, which may be incomplete; or a scene, which is run while its
    /// results are shown.
    pub path: PathBuf,
    /// Folder for the results of a scene; without it they are deleted when the viewer ends.
    #[arg(short, long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Port on 127.0.0.1; the default 0 chooses a free one.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,
    /// Open the page in the browser.
    #[arg(long)]
    pub open: bool,
    /// Folder of a trained model to evaluate on a data set.
    #[arg(long, value_name = "DIR")]
    pub model: Option<PathBuf>,
    /// Largest number of grasps shown in 3-D, evenly spread over all.
    #[arg(long, value_name = "N", default_value_t = DEFAULT_GRASPS)]
    pub grasps: usize,
    /// Format of the address on stdout, and of the report of a scene.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Serves the page of a folder, or of the results of a scene that it runs, until an end is requested.
///
/// # Errors
/// Fails if there is nothing to show, the port is taken, or the scene cannot run.
pub fn view(args: &ViewArgs, console: &dyn Console) -> Result<u8> {
    let scene = args.path.extension().is_some_and(|ending| ending == "ron");
    if !scene && args.out.is_some() {
        return Err(argument_error("-o DIR is the folder of the results of a scene, and is allowed with a scene only"));
    }
    if !scene && !holds_results(&args.path) && !is_held(&args.path) {
        let message = "contains no results to show; allowed: a folder that `tactus run`, `dataset`, `train` or `bench` \
            writes, or a scene (FILE.ron)";
        return Err(Error::file(&args.path, message));
    }
    let (out, _kept) = if scene { folder(args.out.as_deref())? } else { (args.path.clone(), None) };
    // The scene is checked before the page is served, so that an invalid one fails at once.
    let run_args =
        RunArgs { scene: args.path.clone(), out: Some(out.clone()), format: args.format, ..RunArgs::default() };
    if scene {
        run_args.load()?;
    }
    let wishes = ReportOptions { model: args.model.clone(), split: None, grasps: args.grasps, frames: DEFAULT_FRAMES };
    let viewer = Viewer::start(out, wishes, args.port)?;
    let address = viewer.address();
    console.print(&match args.format {
        Format::Text => format!("{address}\n"),
        Format::Json => format!("{}\n", json!({ "address": address })),
    })?;
    if args.open {
        open_browser(&address, console);
    }
    let code = if scene { run(&run_args, console)? } else { EXIT_OK };
    viewer.wait();
    Ok(code)
}
