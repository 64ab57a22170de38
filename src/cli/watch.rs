//! Observer of running grasps: writes frames to disk and moves a bar.

use crate::error::{Error, Result};
use crate::model::Model;
use crate::record::{Frame, PadTopology};
use crate::run::GraspRecorder;
use crate::run::RunRecorder;
use crate::run::{Observer, Outcome};
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Records every frame as it comes and shows the progress of the run.
pub struct Watch {
    model: Arc<Model>,
    topologies: Vec<PadTopology>,
    recorder: Option<Mutex<RunRecorder>>,
    /// Grasps being recorded.
    open: Mutex<BTreeMap<usize, GraspRecorder>>,
    bar: ProgressBar,
    ended: AtomicUsize,
    clock: Instant,
}

impl Watch {
    /// Returns an observer for a run of `grasps` grasps. The bar is drawn on stderr, and only if that is a terminal.
    pub fn new(model: &Arc<Model>, recorder: Option<RunRecorder>, grasps: usize) -> Self {
        let bar = ProgressBar::new((grasps * model.levels.len()) as u64);
        // The template is a constant; if it were wrong the default style would do.
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} frame {pos}/{len}  {msg}  {elapsed}") {
            bar.set_style(style);
        }
        Self {
            // For the recorder alone.
            topologies: recorder.iter().flat_map(|_| &model.fingers).map(|f| PadTopology::clone(&f.topology)).collect(),
            model: model.clone(),
            recorder: recorder.map(Mutex::new),
            open: Mutex::default(),
            bar,
            ended: AtomicUsize::new(0),
            clock: Instant::now(),
        }
    }

    /// Returns the number of grasps that have ended.
    pub fn ended(&self) -> usize {
        self.ended.load(Ordering::Relaxed)
    }

    /// Removes the bar and returns the recorder.
    pub fn finish(self) -> Option<RunRecorder> {
        self.bar.finish_and_clear();
        self.recorder.map(|r| r.into_inner().unwrap_or_else(PoisonError::into_inner))
    }
}

fn lock<T>(mutex: &Mutex<T>) -> Result<MutexGuard<'_, T>> {
    mutex.lock().map_err(|_| Error::Solver("another grasp panicked while recording".into()))
}

impl Observer for Watch {
    fn frame(&self, index: usize, frame: &Frame) -> Result<()> {
        if let Some(recorder) = &self.recorder {
            // Out of the map while it writes, so that other grasps need not wait.
            let open = lock(&self.open)?.remove(&index);
            let mut grasp = match open {
                Some(grasp) => grasp,
                None => lock(recorder)?.begin_grasp(index, &self.topologies, &self.model.object.surface)?,
            };
            grasp.frame(frame)?;
            lock(&self.open)?.insert(index, grasp);
        }
        self.bar.inc(1);
        Ok(())
    }

    fn end(&self, index: usize, outcome: &Outcome) -> Result<()> {
        if let Some(recorder) = &self.recorder {
            let grasp = lock(&self.open)?.remove(&index);
            let summary = outcome.summary.clone();
            match grasp {
                Some(grasp) => lock(recorder)?.end_grasp(grasp, summary)?,
                None => lock(recorder)?.skip_grasp(index, summary)?,
            }
        }
        let missing = self.model.levels.len().saturating_sub(outcome.summary.frames);
        self.bar.inc(missing as u64);
        let ended = self.ended.fetch_add(1, Ordering::Relaxed) + 1;
        self.bar.set_message(format!("{:.2} grasps/s", ended as f64 / self.clock.elapsed().as_secs_f64()));
        Ok(())
    }
}
