//! Option `--watch`: a page in the browser that shows results while they are written.

use super::console::Console;
use base::error::{Error, Result};
use report::view::Viewer;
use report::{DEFAULT_FRAMES, ReportOptions};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// Default number of grasps in 3-D.
pub(super) const DEFAULT_GRASPS: usize = 8;

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

/// Runs `work`, which writes into `dir`. With `--watch`, it also serves the page of the folder until an end is
/// requested.
///
/// # Errors
/// Fails if the port is taken or `work` fails; an error also ends the page.
pub(super) fn run_watched(
    args: &WatchArgs,
    dir: &Path,
    console: &dyn Console,
    work: impl FnOnce() -> Result<u8>,
) -> Result<u8> {
    if !args.watch {
        return work();
    }
    let wishes = ReportOptions { model: None, split: None, grasps: DEFAULT_GRASPS, frames: DEFAULT_FRAMES };
    let viewer = Viewer::start(dir.to_path_buf(), wishes, args.port)?;
    let address = viewer.address();
    console.print_message(&format!("{} is shown at {address}", dir.display()));
    if std::io::stderr().is_terminal() && has_display() {
        open_browser(&address, console);
    }
    let code = work()?;
    console.print_message(&format!("{address} is available until Ctrl-C"));
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

/// Opens the page in the browser, or says why it cannot.
pub(super) fn open_browser(address: &str, console: &dyn Console) {
    if let Err(error) = open::that_detached(address) {
        console.warn(&format!("note: no browser could be opened ({error}); the page is at {address}"));
    }
}
