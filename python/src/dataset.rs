//! Data sets as NumPy arrays, one grasp at a time.

use crate::arrays::{pad, put, surface};
use crate::refusal::refused;
use crate::supervise::supervise;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;
use tactus::base::error::Error;
use tactus::dataset::{self, Campaign};
use tactus::record::names;
use tactus::scene::load_set;

/// Data set on disk.
#[pyclass(frozen)]
pub struct Files(Arc<dataset::DataSet>);

#[pymethods]
impl Files {
    #[new]
    fn new(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        Ok(Self(Arc::new(supervise(py, Some(1), move || dataset::DataSet::open(folder))?)))
    }

    /// Returns the reasons why objects are excluded, one sentence each.
    fn damaged(&self) -> Vec<String> {
        self.0.damaged.iter().map(Error::to_string).collect()
    }

    /// Returns the name, the number of grasps and the indices of the grasps that reached their load, for each object.
    fn objects(&self) -> Vec<(String, usize, Vec<usize>)> {
        self.0.objects.iter().map(|o| (o.name.clone(), o.sizes.grasps, o.reached().collect())).collect()
    }

    /// Returns (object, grasp) of the training or the test set of the split by poses.
    fn split(&self, test: bool) -> Vec<(String, usize)> {
        let sets = &self.0.splits.poses;
        let chosen = self.0.select(if test { &sets.test } else { &sets.train });
        chosen.into_iter().map(|(object, grasp)| (self.0.objects[object].name.clone(), grasp)).collect()
    }

    /// Returns the arrays of a grasp.
    fn grasp<'py>(&self, py: Python<'py>, object: &str, grasp: usize) -> PyResult<Bound<'py, PyDict>> {
        let at = self.index(object)?;
        let set = self.0.clone();
        let data = supervise(py, Some(1), move || set.objects[at].grasp(grasp))?;
        let (pads, nodes) = (self.0.objects[at].sizes.pads, self.0.objects[at].sizes.nodes);
        let (arrays, f) = (PyDict::new(py), data.frames);
        put(&arrays, names::DISPLACEMENT, &data.displacement, &[f, pads, nodes, 3])?;
        put(&arrays, names::CONTACT_FORCE, &data.contact_force, &[f, pads, nodes, 3])?;
        put(&arrays, names::VON_MISES, &data.von_mises, &[f, pads, nodes])?;
        put(&arrays, names::FORCE, &data.force, &[f])?;
        put(&arrays, names::TRAVEL, &data.travel, &[f, pads])?;
        put(&arrays, names::FINGER_POSITION, &data.finger_position, &[f, pads])?;
        put(&arrays, names::OBJECT_POSE, &data.object_pose, &[f, 7])?;
        put(&arrays, names::OBJECT_LOAD, &data.object_load, &[f, 6])?;
        put(&arrays, names::WRENCH, &data.wrench, &[f, pads, 6])?;
        put(&arrays, names::GRASP_POSE, &data.grasp_pose, &[7])?;
        let tactile = PyDict::new(py);
        data.tactile.iter().try_for_each(|array| put(&tactile, &array.name, &array.values, &array.shape))?;
        arrays.set_item("tactile", tactile)?;
        Ok(arrays)
    }

    /// Returns the pads of an object, left first.
    fn pads<'py>(&self, py: Python<'py>, object: &str) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let file = &self.0.objects[self.index(object)?];
        let placed = file.pads.iter().zip(&file.pad_poses).zip(&file.closing);
        placed.map(|((mesh, pose), closing)| pad(py, mesh, pose, *closing)).collect()
    }

    /// Returns the surface of an object.
    fn surface<'py>(&self, py: Python<'py>, object: &str) -> PyResult<Bound<'py, PyDict>> {
        surface(py, &self.0.objects[self.index(object)?].object)
    }

    /// Returns the scene of an object as RON.
    fn scene(&self, object: &str) -> PyResult<String> {
        Ok(self.0.objects[self.index(object)?].scene.clone())
    }
}

impl Files {
    fn index(&self, name: &str) -> PyResult<usize> {
        let names = || self.0.objects.iter().map(|o| o.name.as_str()).collect::<Vec<_>>().join(", ");
        let found = self.0.objects.iter().position(|o| o.name == name);
        found.ok_or_else(|| refused(format!("the data set has no object {name:?}; it has: {}", names())))
    }
}

/// Computes part (i, n) of a data set, i from 0 to n - 1; without a part, the remaining grasps, and finishes the data
/// set. Returns the number of computed grasps.
#[pyfunction]
pub fn make(
    py: Python<'_>,
    scene: PathBuf,
    out: PathBuf,
    part: Option<(usize, usize)>,
    threads: usize,
) -> PyResult<usize> {
    supervise(py, Some(threads), move || {
        let mut campaign = Campaign::plan(&load_set(scene)?, &out, tactus::backend::choose)?;
        let left = campaign.manifest().grasps - campaign.finished();
        match part {
            Some((part, parts)) => campaign.run_part(part, parts.max(1), threads.max(1), &()),
            None => campaign.run(threads.max(1), &()).map(|_| left),
        }
    })
}
