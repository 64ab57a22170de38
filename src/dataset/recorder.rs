//! Recorder of the frames of a grasp: writes its rows to the file of the object, then the record that it is finished.

use super::file::Writer;
use super::progress::{FinishedGrasp, ProgressRecords};
use super::rows::{Encoder, GraspRows};
use super::sampling::Sampling;
use base::error::{Error, Result};
use geometry::Pose;
use model::Model;
use model::evaluation::evaluate;
use record::{self, Frame, PadTopology};
use scene::{Expectation, NamedScene};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use world::run::{Observer, Outcome};

/// Observer of the progress of a data set; its methods are called from any thread.
pub trait DatasetObserver: Sync {
    /// Reports a frame of a grasp.
    fn frame(&self) {}
    /// Reports the end of a grasp of `object`.
    fn grasp(&self, _object: &str, _finished: &FinishedGrasp) {}
    /// Reports a notice for the user, one sentence.
    fn notice(&self, _notice: &str) {}
}

/// Observer that ignores everything.
impl DatasetObserver for () {}

/// Recorder of the frames of the grasps of one object.
pub struct DatasetRecorder<'a> {
    name: &'a str,
    expect: Vec<Expectation>,
    poses: &'a [Pose],
    topologies: Vec<&'a PadTopology>,
    /// Map to the pads of the scene, if a finer mesh is simulated.
    sampling: Option<Sampling>,
    encoder: Encoder,
    writer: Writer,
    progress: &'a ProgressRecords,
    watcher: &'a dyn DatasetObserver,
    /// Rows of the running grasps.
    open: Mutex<BTreeMap<usize, GraspRows>>,
}

impl<'a> DatasetRecorder<'a> {
    /// Creates a recorder for the grasps at `poses` of an object: frames of the model `simulated` are stored at the
    /// nodes of the model `recorded`.
    pub fn new(
        object: &'a NamedScene,
        poses: &'a [Pose],
        [simulated, recorded]: [&'a Arc<Model>; 2],
        (encoder, writer): (Encoder, Writer),
        progress: &'a ProgressRecords,
        watcher: &'a dyn DatasetObserver,
    ) -> Self {
        let sampling = (!Arc::ptr_eq(simulated, recorded)).then(|| Sampling::new(simulated, recorded.clone()));
        let topologies = recorded.fingers.iter().map(|f| f.topology.as_ref()).collect();
        // `ReachesForce` is omitted: the statuses of the grasps are counted separately.
        let of_frames =
            object.scene.expectations().into_owned().into_iter().filter(|e| !matches!(e, Expectation::ReachesForce));
        let (name, expect) = (object.name.as_str(), of_frames.collect());
        Self { name, expect, poses, topologies, sampling, encoder, writer, progress, watcher, open: Mutex::default() }
    }

    fn take(&self, grasp: usize) -> GraspRows {
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner).remove(&grasp);
        open.unwrap_or_else(|| self.encoder.rows(&self.poses[grasp]))
    }
}

impl Observer for DatasetRecorder<'_> {
    fn frame(&self, index: usize, frame: &Frame) -> Result<()> {
        let sampled = self.sampling.as_ref().map(|sampling| sampling.frame(frame));
        let frame = sampled.as_ref().unwrap_or(frame);
        // A non-finite number would silently corrupt a training set.
        record::check::frame(&self.topologies, frame)
            .map_err(|m| Error::Solver(format!("{}, grasp {index}: frame not recorded: {m}", self.name)))?;
        let mut rows = self.take(index);
        self.encoder.frame(&mut rows, frame);
        self.open.lock().unwrap_or_else(PoisonError::into_inner).insert(index, rows);
        self.watcher.frame();
        Ok(())
    }

    fn end(&self, index: usize, outcome: &Outcome) -> Result<()> {
        let mut rows = self.take(index);
        let s = &outcome.summary;
        let checksum = self.encoder.finish(&mut rows, s.status, s.reason.as_deref().unwrap_or(""), s.frames);
        self.writer.write(index, &rows)?;
        let judged = self.expect.iter().filter(|_| s.frames > 0);
        let finished = FinishedGrasp {
            grasp: index,
            status: s.status,
            reason: s.reason.clone(),
            frames: s.frames,
            checksum: checksum.to_hex().to_string(),
            expectations: judged.map(|e| evaluate(e, &outcome.measured)).collect(),
        };
        self.progress.record_grasp(&finished)?;
        self.watcher.grasp(self.name, &finished);
        Ok(())
    }
}
