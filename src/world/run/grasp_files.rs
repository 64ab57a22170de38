//! Files of one grasp. Grasps are independent of each other, so several may be recorded at once from different threads.

use super::options::RecordingOptions;
use base::error::{Error, Result};
use base::files::atomic::{create_dir, write_atomic};
use geometry::mesh::TriMesh;
use glam::{DQuat, DVec3};
use record::arrays::GraspArrays;
use record::csv::FramesCsv;
use record::frame::{Frame, PadTopology};
use record::pvd::Collection;
use record::render::{self, Style};
use record::{check, vtu};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Least time between two writes of the arrays, over the duration of a write.
const WORK: u32 = 10;

/// Recorder that writes the frames of one grasp as they arrive. If it is dropped early, it still writes its pending
/// arrays.
#[derive(Debug)]
pub struct GraspRecorder {
    index: usize,
    dir: PathBuf,
    options: RecordingOptions,
    topologies: Vec<PadTopology>,
    object: TriMesh,
    csv: Option<FramesCsv>,
    collection: Option<Collection>,
    arrays: Option<GraspArrays>,
    /// Latest file of the object, and the pose in it.
    shown: Option<(String, (DVec3, DQuat))>,
    last: Option<Frame>,
    frames: usize,
    /// Time of the last write of the arrays, and its duration.
    written: (Instant, Duration),
}

impl GraspRecorder {
    /// Starts recording in `run_dir/grasp_<index>`. `object` is the object's surface in the object frame, m.
    ///
    /// # Errors
    /// Fails if a pad or the object cannot be recorded, and if the directory or a file cannot be created.
    pub fn create(
        run_dir: &Path,
        options: &RecordingOptions,
        index: usize,
        topologies: &[PadTopology],
        object: &TriMesh,
    ) -> Result<Self> {
        let dir = run_dir.join(directory(index));
        let refuse = |message: String| Error::file(&dir, format!("grasp {index} not recorded: {message}"));
        for (pad, topology) in topologies.iter().enumerate() {
            check::topology(pad, topology).map_err(refuse)?;
        }
        check::object(object).map_err(refuse)?;
        create_dir(&if options.vtu { dir.join("frames") } else { dir.clone() })?;
        let csv = options
            .csv
            .then(|| FramesCsv::create(&dir.join("frames.csv"), topologies.len(), options.moving, options.predicted))
            .transpose()?;
        let arrays =
            options.arrays.then(|| GraspArrays::new(dir.join("arrays.npz"), topologies, &options.pads)).transpose()?;
        let collection = options.vtu.then(|| Collection::new(dir.join("run.pvd")));
        Ok(GraspRecorder {
            index,
            dir,
            options: options.clone(),
            topologies: topologies.to_vec(),
            object: object.clone(),
            csv,
            collection,
            arrays,
            shown: None,
            last: None,
            frames: 0,
            written: (Instant::now(), Duration::ZERO),
        })
    }

    /// Returns the number of the grasp in its run.
    pub fn index(&self) -> usize {
        self.index
    }

    /// Returns the directory of the files.
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Records the next frame.
    ///
    /// # Errors
    /// Fails, and writes nothing, if the frame is not the next one, if a number is not finite or if a size does not
    /// match. Fails if a file cannot be written.
    pub fn frame(&mut self, frame: &Frame) -> Result<()> {
        if frame.index != self.frames {
            let message = format!("frame {} recorded, frame {} is next", frame.index, self.frames);
            return Err(Error::file(&self.dir, message));
        }
        check::frame(&self.topologies, frame)
            .map_err(|message| Error::file(&self.dir, format!("frame not recorded: {message}")))?;
        if let Some(collection) = &mut self.collection {
            let pads = format!("frames/frame_{:04}.vtu", frame.index);
            write_atomic(&self.dir.join(&pads), vtu::pads(&self.topologies, frame).as_bytes())?;
            let here = (frame.to_display_point(frame.object_position), frame.display_rotation());
            let object = match &self.shown {
                // The object is still at the pose of this file.
                Some((file, there)) if near(*there, here) => file.clone(),
                _ => {
                    let file = format!("frames/object_{:04}.vtu", frame.index);
                    write_atomic(&self.dir.join(&file), vtu::object(&self.object, frame).as_bytes())?;
                    self.shown = Some((file.clone(), here));
                    file
                }
            };
            let at = if frame.moving.is_some() { frame.time } else { frame.applied_force };
            collection.push(at, &[&pads, &object])?;
        }
        if let Some(csv) = &mut self.csv {
            csv.push(frame)?;
        }
        if let Some(arrays) = &mut self.arrays {
            arrays.push(frame);
            // Rewriting the whole archive per frame would cost time quadratic in the number of frames.
            let (at, took) = self.written;
            if at.elapsed() >= self.options.flush_after.max(took * WORK) {
                let clock = Instant::now();
                arrays.write()?;
                self.written = (Instant::now(), clock.elapsed());
            }
        }
        if self.options.picture.is_some() {
            self.last = Some(frame.clone());
        }
        self.frames += 1;
        Ok(())
    }

    /// Writes the remaining files: the arrays and the picture of the last frame.
    ///
    /// # Errors
    /// Fails if a file cannot be written or the picture cannot be drawn.
    pub fn finish(mut self) -> Result<()> {
        if let Some(mut arrays) = self.arrays.take()
            && arrays.pending() > 0
        {
            arrays.write()?;
        }
        if let (Some(scalar), Some(frame)) = (self.options.picture, &self.last) {
            let title = format!("{}, grasp {:03}", self.options.object_name, self.index);
            let style = Style { scalar, title, ..Style::default() };
            let picture = render::render_pads(&self.topologies, frame, Some(&self.object), &style)?;
            render::save(&picture, &self.dir.join("pads.png"))?;
        }
        Ok(())
    }
}

impl Drop for GraspRecorder {
    fn drop(&mut self) {
        if let Some(arrays) = &mut self.arrays
            && arrays.pending() > 0
        {
            // The cause of the early end has its own error; this one cannot be returned.
            let _ = arrays.write();
        }
    }
}

/// Returns the name of a grasp's directory.
pub fn directory(index: usize) -> String {
    format!("grasp_{index:03}")
}

/// Returns true if two poses differ only by rounding: 1 nm, 1 nrad.
fn near((p, q): (DVec3, DQuat), (other, turned): (DVec3, DQuat)) -> bool {
    (p - other).abs().max_element() <= 1e-9 && (q - turned).length() <= 1e-9
}
