//! Observer of running grasps that advances a progress bar.

use super::console::Console;
use base::error::Result;
use base::number::format_number;
use indicatif::{ProgressBar, ProgressStyle};
use record::Frame;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;
use world::run::{Observer, Outcome};

/// Shows the progress of a run.
pub struct RunProgress<'c> {
    bar: ProgressBar,
    /// Console that prints a line for each frame; None if not requested.
    follower: Option<&'c dyn Console>,
    frames: usize,
    ended: AtomicUsize,
    clock: Instant,
}

impl<'c> RunProgress<'c> {
    /// Creates an observer with a progress bar on `console` of one step for each of the `frames` of each of the
    /// `grasps`. It also prints a line for each frame if the console requests details.
    pub fn new(console: &'c dyn Console, grasps: usize, frames: usize) -> Self {
        let bar = console.attach_progress_bar(ProgressBar::new((grasps * frames) as u64));
        // The template is a constant; if it were invalid, the default style would be used.
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} frame {pos}/{len}  {msg}  {elapsed}") {
            bar.set_style(style);
        }
        Self {
            bar,
            follower: console.is_verbose().then_some(console),
            frames,
            ended: AtomicUsize::new(0),
            clock: Instant::now(),
        }
    }

    /// Returns the number of grasps that have ended, and removes the bar.
    pub fn finish(&self) -> usize {
        self.bar.finish_and_clear();
        self.ended.load(Ordering::Relaxed)
    }
}

/// Describes a frame of grasp `grasp` in a line.
fn line(grasp: usize, frame: &Frame) -> String {
    let travel: Vec<String> = frame.travel.iter().map(|t| format!("{:.4}", t * 1e3)).collect();
    format!(
        "grasp {grasp} frame {}: {} N, travel {} mm, {} iterations, residual {:.1e} N, force balance {:.1e}, gap {:.2} um, det F from {:.3}",
        frame.index,
        format_number(frame.applied_force),
        travel.join(" and "),
        frame.newton_iterations,
        frame.residual,
        frame.force_balance,
        frame.min_gap * 1e6,
        frame.min_det_f
    )
}

impl Observer for RunProgress<'_> {
    fn frame(&self, index: usize, frame: &Frame) -> Result<()> {
        if let Some(console) = self.follower {
            self.bar.suspend(|| console.print_message(&line(index, frame)));
        }
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
