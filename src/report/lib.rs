//! Report of results as one self-contained HTML page: tables, charts, and pads in 3-D.
//!
//! ```text
//! folder -> source.rs: bench | sizes | run | data set | training
//!        -> bench.rs, run.rs, evaluation.rs, ...: Section (tables, charts) + Recording (frames of a grasp)
//!        -> page.rs: one HTML file; table.rs also as Markdown
//!           page/: style, viewer and charts, embedded in the page
//! ```

mod bench;
mod chart;
mod evaluation;
mod packed;
mod page;
mod recording;
mod run;
mod source;
mod training;
mod unfinished;
pub mod view;

pub use chart::Chart;
pub use page::{Page, PageBlock, Section};
pub use recording::{Errors, RecordedState, Recording};
pub use source::{DEFAULT_FRAMES, ReportOptions, holds_results};

use base::error::{Error, Result};
use source::{Source, sources};
use std::path::PathBuf;

/// Builds the page of the results in `dirs`, in the same order.
///
/// # Errors
/// Fails if a folder has no results, if results cannot be read, or if there is a model but no data set to evaluate it
/// on.
pub fn report(dirs: &[PathBuf], wishes: &ReportOptions) -> Result<Page> {
    let found = dirs.iter().map(|dir| sources(dir)).collect::<Result<Vec<_>>>()?.concat();
    if let Some(model) = &wishes.model
        && !found.iter().any(|source| matches!(source, Source::Data(_)))
    {
        let message = "needs a data set for its evaluation, and none of the folders contains one";
        return Err(Error::file(model, message));
    }
    let mut page = Page::default();
    for source in &found {
        let first = page.sections.len();
        match source {
            Source::Bench(dir) => bench::comparison_section(dir, &mut page)?,
            Source::Sizes(dir) => bench::size_section(dir, &mut page)?,
            Source::Run(dir) => run::run(dir, wishes, &mut page)?,
            Source::Data(dir) => evaluation::data_set(dir, wishes, &mut page)?,
            Source::Training(dir) => training::training(dir, &mut page)?,
        }
        page.sections[first..].iter_mut().for_each(|section| section.modified = source.modified());
    }
    Ok(page)
}
