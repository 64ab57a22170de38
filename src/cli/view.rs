//! Command `tactus view`, and `--watch` of other commands: a page in the browser that shows results while they are
//! written.

use super::console::Console;
use super::run::{RunArgs, refused, run};
use super::{Format, OK};
use base::error::{Error, Result};
use base::files::lock::is_held;
use report::view::Viewer;
use report::{FRAMES, ReportOptions, holds_results};
use serde_json::json;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// Default number of grasps in 3-D.
const GRASPS: usize = 8;

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
    #[arg(long, value_name = "N", default_value_t = GRASPS)]
    pub grasps: usize,
    /// Format of the address on stdout, and of the report of a scene.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of commands that have `--watch`.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct WatchArgs {
    /// Show the results in the browser while they are written, until Ctrl-C. The browser opens automatically if stderr
    /// is a terminal with a display.
    #[arg(long)]
    pub watch: bool,
    /// Port of the page on 127.0.0.1; the default 0 chooses a free one.
    #[arg(long, value_name = "N", requires = "watch", default_value_t = 0)]
    pub port: u16,
}

/// Serves the page of a folder, or of the results of a scene that it runs, until an end is requested.
///
/// # Errors
/// Fails if there is nothing to show, the port is taken, or the scene cannot run.
pub fn view(args: &ViewArgs, console: &dyn Console) -> Result<u8> {
    let scene = args.path.extension().is_some_and(|ending| ending == "ron");
    if !scene && args.out.is_some() {
        return Err(refused("-o DIR is the folder of the results of a scene, and is allowed with a scene only"));
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
    let wishes = ReportOptions { model: args.model.clone(), split: None, grasps: args.grasps, frames: FRAMES };
    let viewer = Viewer::start(out, wishes, args.port)?;
    let address = viewer.address();
    console.print(&match args.format {
        Format::Text => format!("{address}\n"),
        Format::Json => format!("{}\n", json!({ "address": address })),
    })?;
    if args.open {
        open_browser(&address, console);
    }
    let code = if scene { run(&run_args, console)? } else { OK };
    viewer.wait();
    Ok(code)
}

/// Runs `work`, which writes into `dir`. With `--watch`, it also serves the page of the folder until an end is
/// requested.
///
/// # Errors
/// Fails if the port is taken or `work` fails; an error also ends the page.
pub(super) fn watched(
    args: &WatchArgs,
    dir: &Path,
    console: &dyn Console,
    work: impl FnOnce() -> Result<u8>,
) -> Result<u8> {
    if !args.watch {
        return work();
    }
    let wishes = ReportOptions { model: None, split: None, grasps: GRASPS, frames: FRAMES };
    let viewer = Viewer::start(dir.to_path_buf(), wishes, args.port)?;
    let address = viewer.address();
    console.say(&format!("{} is shown at {address}", dir.display()));
    if std::io::stderr().is_terminal() && has_display() {
        open_browser(&address, console);
    }
    let code = work()?;
    console.say(&format!("{address} is available until Ctrl-C"));
    viewer.wait();
    Ok(code)
}

/// Returns the folder for results. If `out` is None, this is a new temporary folder, which exists until the second
/// value is dropped.
pub(super) fn folder(out: Option<&Path>) -> Result<(PathBuf, Option<tempfile::TempDir>)> {
    match out {
        Some(dir) => Ok((dir.to_path_buf(), None)),
        None => {
            let made = tempfile::Builder::new().prefix("tactus-").tempdir();
            let dir = made.map_err(|e| {
                Error::Start(format!("cannot create a temporary folder: {e}; give a folder with -o DIR"))
            })?;
            Ok((dir.path().to_path_buf(), Some(dir)))
        }
    }
}

/// Returns true if the system can display a browser.
fn has_display() -> bool {
    !cfg!(target_os = "linux") || ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some())
}

fn open_browser(address: &str, console: &dyn Console) {
    if let Err(error) = open::that_detached(address) {
        console.warn(&format!("note: no browser could be opened ({error}); the page is at {address}"));
    }
}
