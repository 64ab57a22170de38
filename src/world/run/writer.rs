//! Observer that writes grasps into the folder of a run while they run.

use super::{GraspRecorder, Observer, Outcome, RunRecorder};
use base::error::{Error, Result};
use model::Model;
use record::{Frame, PadTopology};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Writer of a run: writes every frame when it arrives.
#[derive(Debug)]
pub struct RunWriter {
    model: Arc<Model>,
    topologies: Vec<PadTopology>,
    recorder: Mutex<RunRecorder>,
    /// Grasps being recorded.
    open: Mutex<BTreeMap<usize, GraspRecorder>>,
}

impl RunWriter {
    /// Creates an observer that writes with `recorder`.
    pub fn new(model: &Arc<Model>, recorder: RunRecorder) -> Self {
        let topologies = model.fingers.iter().map(|f| PadTopology::clone(&f.topology)).collect();
        Self { model: model.clone(), topologies, recorder: Mutex::new(recorder), open: Mutex::default() }
    }

    /// Returns a notice for the user if the directory is held without a lock of the system.
    pub fn notice(&self) -> Option<String> {
        self.recorder.lock().unwrap_or_else(PoisonError::into_inner).notice()
    }

    /// Returns the recorder, to complete the run.
    pub fn finish(self) -> RunRecorder {
        self.recorder.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> Result<MutexGuard<'_, T>> {
    mutex.lock().map_err(|_| Error::Solver("another grasp panicked while recording".into()))
}

impl Observer for RunWriter {
    fn frame(&self, index: usize, frame: &Frame) -> Result<()> {
        // Removed from the map while it writes, so that other grasps need not wait.
        let open = lock(&self.open)?.remove(&index);
        let mut grasp = match open {
            Some(grasp) => grasp,
            None => lock(&self.recorder)?.begin_grasp(index, &self.topologies, &self.model.object.surface)?,
        };
        grasp.frame(frame)?;
        lock(&self.open)?.insert(index, grasp);
        Ok(())
    }

    fn end(&self, index: usize, outcome: &Outcome) -> Result<()> {
        let grasp = lock(&self.open)?.remove(&index);
        let summary = outcome.summary.clone();
        match grasp {
            Some(grasp) => lock(&self.recorder)?.end_grasp(grasp, summary),
            None => lock(&self.recorder)?.skip_grasp(index, summary),
        }
    }
}
