//! Observer of running grasps that moves a bar.

use crate::error::Result;
use crate::record::Frame;
use crate::run::{Observer, Outcome};
use indicatif::{ProgressBar, ProgressStyle};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Shows the progress of a run.
pub struct RunProgress {
    bar: ProgressBar,
    frames: usize,
    ended: AtomicUsize,
    clock: Instant,
}

impl RunProgress {
    /// Returns an observer that moves `bar`: a step for each of the `frames` of a grasp.
    pub fn new(bar: ProgressBar, frames: usize) -> Self {
        // The template is a constant; if it were wrong the default style would do.
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} frame {pos}/{len}  {msg}  {elapsed}") {
            bar.set_style(style);
        }
        Self { bar, frames, ended: AtomicUsize::new(0), clock: Instant::now() }
    }

    /// Returns the number of grasps that have ended, and removes the bar.
    pub fn finish(&self) -> usize {
        self.bar.finish_and_clear();
        self.ended.load(Ordering::Relaxed)
    }
}

impl Observer for RunProgress {
    fn frame(&self, _index: usize, _frame: &Frame) -> Result<()> {
        self.bar.inc(1);
        Ok(())
    }

    fn end(&self, _index: usize, outcome: &Outcome) -> Result<()> {
        self.bar.inc(self.frames.saturating_sub(outcome.summary.frames) as u64);
        let ended = self.ended.fetch_add(1, Ordering::Relaxed) + 1;
        self.bar.set_message(format!("{:.2} grasps/s", ended as f64 / self.clock.elapsed().as_secs_f64()));
        Ok(())
    }
}
