//! `arrays.npz`: frames of a grasp as NumPy arrays for `numpy.load`. Names are defined in [`super::names`]; shapes,
//! units and frames are in `docs/data-format.md`.
//!
//! Nodes and tetrahedra of the pads are concatenated, left pad first; `pad_of_node` and `pad_of_tet` hold the pad
//! index, and `tets` uses the concatenated node indices.

use super::frame::{Frame, PadTopology};
use super::{TactileArray, names};
use base::error::{Error, Result};
use base::files::atomic::replace_durable;
use geometry::Pose;
use glam::DVec3;
use ndarray::{ArrayView, Dimension, ShapeBuilder, StrideShape};
use ndarray_npy::{NpzWriter, WritableElement};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Arrays of one grasp, in memory until [`GraspArrays::write`].
#[derive(Debug)]
pub struct GraspArrays {
    path: PathBuf,
    pads: usize,
    pad_pose: Vec<f64>,
    rest: Vec<f64>,
    tets: Vec<u32>,
    tet_width: usize,
    bonded: Vec<bool>,
    pad_of_node: Vec<u32>,
    pad_of_tet: Vec<u32>,
    frames: usize,
    written: usize,
    position: Vec<f64>,
    displacement: Vec<f64>,
    contact_force: Vec<f64>,
    von_mises_node: Vec<f64>,
    von_mises_element: Vec<f64>,
    gap: Vec<f64>,
    object_pose: Vec<f64>,
    object_load: Vec<f64>,
    force: Vec<f64>,
    time: Vec<f64>,
    travel: Vec<f64>,
    wrench: Vec<f64>,
    hand_pose: Vec<f64>,
    object_motion: Vec<f64>,
    ground_force: Vec<f64>,
    /// Tactile arrays, each with the values of all frames concatenated.
    tactile: Vec<TactileArray>,
}

impl GraspArrays {
    /// Creates the arrays of a grasp with these pads, to be written to `path`. `poses` are the pad poses at zero
    /// travel, empty if unknown.
    ///
    /// # Errors
    /// Fails if linear and quadratic pads are mixed.
    pub fn new(path: PathBuf, topologies: &[PadTopology], poses: &[Pose]) -> Result<Self> {
        let width = topologies.first().map_or(4, |t| t.elements.width());
        if topologies.iter().any(|t| t.elements.width() != width) {
            return Err(Error::file(
                path,
                "linear and quadratic pads cannot share one `tets` array; switch off the arrays",
            ));
        }
        let mut arrays = GraspArrays {
            path,
            pads: topologies.len(),
            pad_pose: poses.iter().flat_map(Pose::row).collect(),
            rest: Vec::new(),
            tets: Vec::new(),
            tet_width: width,
            bonded: Vec::new(),
            pad_of_node: Vec::new(),
            pad_of_tet: Vec::new(),
            frames: 0,
            written: 0,
            position: Vec::new(),
            displacement: Vec::new(),
            contact_force: Vec::new(),
            von_mises_node: Vec::new(),
            von_mises_element: Vec::new(),
            gap: Vec::new(),
            object_pose: Vec::new(),
            object_load: Vec::new(),
            force: Vec::new(),
            time: Vec::new(),
            travel: Vec::new(),
            wrench: Vec::new(),
            hand_pose: Vec::new(),
            object_motion: Vec::new(),
            ground_force: Vec::new(),
            tactile: Vec::new(),
        };
        for (pad, topology) in (0..).zip(topologies) {
            let first = arrays.bonded.len() as u32;
            extend(&mut arrays.rest, &topology.rest);
            arrays.tets.extend(topology.elements.nodes().iter().map(|n| first + n));
            arrays.bonded.extend(&topology.bonded);
            arrays.pad_of_node.extend(std::iter::repeat_n(pad, topology.rest.len()));
            arrays.pad_of_tet.extend(std::iter::repeat_n(pad, topology.elements.len()));
        }
        Ok(arrays)
    }

    /// Appends a frame, which must have passed [`super::check::frame`] for the same topologies.
    pub fn push(&mut self, frame: &Frame) {
        for pad in &frame.pads {
            extend(&mut self.position, &pad.position);
            extend(&mut self.displacement, &pad.displacement);
            extend(&mut self.contact_force, &pad.contact_force);
            self.von_mises_node.extend(&pad.von_mises_node);
            self.von_mises_element.extend(&pad.von_mises_element);
            self.gap.extend(&pad.gap);
            self.wrench.extend(pad.wrench.row());
        }
        let (p, q) = (frame.object_position, frame.object_rotation);
        self.object_pose.extend([p.x, p.y, p.z, q.w, q.x, q.y, q.z]);
        self.object_load.extend(frame.object_load.row());
        if let Some(m) = &frame.moving {
            let (p, q) = (m.hand_position, m.hand_rotation);
            self.hand_pose.extend([p.x, p.y, p.z, q.w, q.x, q.y, q.z]);
            extend(&mut self.object_motion, &[m.velocity, m.spin]);
            extend(&mut self.ground_force, &[m.ground_force]);
        }
        for (k, array) in frame.tactile.iter().enumerate() {
            match self.tactile.get_mut(k) {
                Some(own) => own.values.extend(&array.values),
                None => self.tactile.push(array.clone()),
            }
        }
        self.force.push(frame.applied_force);
        self.time.push(frame.time);
        self.travel.extend(&frame.travel);
        self.frames += 1;
    }

    /// Returns the number of frames not yet written to disk.
    pub fn pending(&self) -> usize {
        self.frames - self.written
    }

    /// Writes all frames so far; the file is replaced atomically.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn write(&mut self) -> Result<()> {
        let path = self.path.clone();
        replace_durable(&path, |temporary| self.write_to(temporary))?;
        self.written = self.frames;
        Ok(())
    }

    fn write_to(&self, path: &Path) -> io::Result<()> {
        let (frames, nodes, tets) = (self.frames, self.bonded.len(), self.pad_of_tet.len());
        let mut npz = NpzWriter::new(BufWriter::new(std::fs::File::create(path)?));
        let out = &mut npz;
        put(out, names::DISPLACEMENT, (frames, nodes, 3), &self.displacement)?;
        put(out, names::POSITION, (frames, nodes, 3), &self.position)?;
        // Fields that are not recorded have no array.
        if !self.contact_force.is_empty() {
            put(out, names::CONTACT_FORCE, (frames, nodes, 3), &self.contact_force)?;
        }
        if !self.von_mises_node.is_empty() {
            put(out, names::VON_MISES, (frames, nodes), &self.von_mises_node)?;
        }
        if !self.von_mises_element.is_empty() {
            put(out, names::ELEMENT_VON_MISES, (frames, tets), &self.von_mises_element)?;
        }
        if !self.gap.is_empty() {
            put(out, names::GAP, (frames, nodes), &self.gap)?;
        }
        put(out, names::OBJECT_POSE, (frames, 7), &self.object_pose)?;
        put(out, names::OBJECT_LOAD, (frames, 6), &self.object_load)?;
        if !self.hand_pose.is_empty() {
            put(out, names::HAND_POSE, (frames, 7), &self.hand_pose)?;
            put(out, names::OBJECT_MOTION, (frames, 6), &self.object_motion)?;
            put(out, names::GROUND_FORCE, (frames, 3), &self.ground_force)?;
        }
        put(out, names::FORCE, frames, &self.force)?;
        put(out, names::TIME, frames, &self.time)?;
        put(out, names::TRAVEL, (frames, self.pads), &self.travel)?;
        put(out, names::WRENCH, (frames, self.pads, 6), &self.wrench)?;
        put(out, names::REST, (nodes, 3), &self.rest)?;
        if !self.pad_pose.is_empty() {
            put(out, names::PAD_POSE, (self.pads, 7), &self.pad_pose)?;
        }
        put(out, names::TETS, (tets, self.tet_width), &self.tets)?;
        put(out, names::BONDED, nodes, &self.bonded)?;
        put(out, names::PAD_OF_NODE, nodes, &self.pad_of_node)?;
        put(out, names::PAD_OF_TET, tets, &self.pad_of_tet)?;
        for TactileArray { name, shape, values, .. } in &self.tactile {
            put(out, name, [&[frames], shape.as_slice()].concat(), values)?;
        }
        npz.finish().map_err(io_error)?.flush()
    }
}

/// Adds an array to an archive.
pub fn put<T, D, S>(npz: &mut NpzWriter<BufWriter<std::fs::File>>, name: &str, shape: S, data: &[T]) -> io::Result<()>
where
    T: WritableElement,
    D: Dimension,
    S: ShapeBuilder<Dim = D> + Into<StrideShape<D>>,
{
    let view = ArrayView::from_shape(shape, data).map_err(io::Error::other)?;
    npz.add_array(name, &view).map_err(io_error)
}

/// Returns the innermost I/O error, so that its kind ("disk full") survives two layers of wrapping.
pub fn io_error(error: ndarray_npy::WriteNpzError) -> io::Error {
    let mut source: Option<&(dyn std::error::Error + 'static)> = Some(&error);
    while let Some(inner) = source {
        if let Some(io) = inner.downcast_ref::<io::Error>() {
            return io::Error::new(io.kind(), io.to_string());
        }
        source = inner.source();
    }
    io::Error::other(error)
}

fn extend(out: &mut Vec<f64>, vectors: &[DVec3]) {
    out.extend(vectors.iter().flat_map(DVec3::to_array));
}
