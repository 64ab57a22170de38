//! Commands of the command line for Python, run in this process.

use crate::progress::{Level, Progress};
use crate::supervise::watch;
use indicatif::{ProgressBar, ProgressDrawTarget};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};
use tactus::base::error::{Error, Result};
use tactus::base::machine::machine_threads;
use tactus::cli::{Cli, Console};

/// Console that stores the output of a command.
#[derive(Default)]
struct Kept {
    report: Mutex<String>,
    bar: Mutex<Option<ProgressBar>>,
    news: Progress,
}

impl Console for Kept {
    fn print(&self, text: &str) -> Result<()> {
        self.report.lock().unwrap_or_else(PoisonError::into_inner).push_str(text);
        Ok(())
    }

    fn print_message(&self, line: &str) {
        self.news.note(Level::Info, line);
    }

    fn warn(&self, line: &str) {
        self.news.note(Level::Warning, line);
    }

    fn attach_progress_bar(&self, bar: ProgressBar) -> ProgressBar {
        bar.set_draw_target(ProgressDrawTarget::hidden());
        *self.bar.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.clone());
        bar
    }
}

impl Kept {
    /// Copies the state of the progress bar.
    fn look(&self) {
        if let Some(bar) = &*self.bar.lock().unwrap_or_else(PoisonError::into_inner) {
            self.news.expect(bar.length().unwrap_or(0) as usize);
            self.news.reach(bar.position() as usize);
        }
    }
}

/// Runs a command with these arguments; returns its exit code and standard output. If `typed`, errors name the
/// command-line options, otherwise the arguments of Python.
#[pyfunction]
pub fn command<'py>(
    py: Python<'py>,
    arguments: Vec<String>,
    typed: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<(u8, String)> {
    let kept = Arc::new(Kept::default());
    let (own, mut told) = (kept.clone(), None);
    let work = move || {
        let arguments = std::iter::once("tactus".to_string()).chain(arguments);
        let refused = |e: clap::Error| Error::Argument(unusable(&e.to_string()));
        let cli = <Cli as clap::Parser>::try_parse_from(arguments).map_err(refused);
        cli.and_then(|cli| cli.command.run(own.as_ref())).map_err(|e| match e {
            Error::Argument(text) if typed => Error::Scene(Error::Argument(text).to_string()),
            other => other,
        })
    };
    let look = |py: Python<'py>| {
        kept.look();
        kept.news.tell(py, progress.as_ref(), &mut told)
    };
    let code = watch(py, Some(machine_threads()), look, work)?;
    let report = std::mem::take(&mut *kept.report.lock().unwrap_or_else(PoisonError::into_inner));
    Ok((code, report))
}

/// Returns the message of clap without its advice on the command line.
fn unusable(text: &str) -> String {
    let before = |mark| text.split(mark).next();
    let first = before("\n\nUsage:").into_iter().chain(before("\n\nFor more information")).min_by_key(|t| t.len());
    let text = first.unwrap_or(text).trim_end();
    text.strip_prefix("error: ").unwrap_or(text).to_string()
}
