//! Data sets as numpy arrays, one grasp at a time.

use crate::refused;
use crate::supervise::supervise;
use numpy::{Element, PyArrayMethods, ToPyArray};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ffi::CString;
use std::path::PathBuf;
use std::sync::Arc;
use tactus::dataset::{self, Campaign};
use tactus::error::Error;
use tactus::record::names;
use tactus::scene::load_set;

/// A data set that `tactus dataset` wrote.
#[pyclass(frozen)]
pub struct DataSet(Arc<dataset::DataSet>);

#[pymethods]
impl DataSet {
    #[new]
    fn new(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let set = supervise(py, Some(1), move || dataset::DataSet::open(folder))?;
        for refused in &set.damaged {
            let text = CString::new(format!("left out: {refused}"))?;
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)?;
        }
        Ok(Self(Arc::new(set)))
    }

    /// Why objects were left out, a sentence each.
    fn damaged(&self) -> Vec<String> {
        self.0.damaged.iter().map(Error::to_string).collect()
    }

    /// Names of the objects.
    fn objects(&self) -> Vec<String> {
        self.0.objects.iter().map(|o| o.name.clone()).collect()
    }

    /// Numbers of the grasps of an object that reached their force.
    fn reached(&self, object: &str) -> PyResult<Vec<usize>> {
        Ok(self.object(object)?.reached().collect())
    }

    /// (object, grasp) of the training or the test set of a split.
    fn split(&self, test: bool) -> Vec<(String, usize)> {
        let sets = &self.0.splits.poses;
        let chosen = self.0.select(if test { &sets.test } else { &sets.train });
        chosen.into_iter().map(|(object, grasp)| (self.0.objects[object].name.clone(), grasp)).collect()
    }

    /// The arrays of a grasp.
    fn grasp<'py>(&self, py: Python<'py>, object: &str, grasp: usize) -> PyResult<Bound<'py, PyDict>> {
        let file = self.object(object)?;
        let (pads, nodes) = (file.sizes.pads, file.sizes.nodes);
        let (set, name) = (self.0.clone(), object.to_string());
        let data = supervise(py, Some(1), move || {
            let file = set.objects.iter().find(|o| o.name == name);
            file.ok_or_else(|| Error::Start(format!("no object {name:?}")))?.grasp(grasp)
        })?;
        let arrays = PyDict::new(py);
        let f = data.frames;
        put(&arrays, names::DISPLACEMENT, &data.displacement, &[f, pads, nodes, 3])?;
        put(&arrays, names::CONTACT_FORCE, &data.contact_force, &[f, pads, nodes, 3])?;
        put(&arrays, names::VON_MISES, &data.von_mises, &[f, pads, nodes])?;
        put(&arrays, names::FORCE, &data.force, &[f])?;
        put(&arrays, names::TRAVEL, &data.travel, &[f, pads])?;
        put(&arrays, names::OBJECT_POSE, &data.object_pose, &[f, 7])?;
        put(&arrays, names::OBJECT_LOAD, &data.object_load, &[f, 6])?;
        put(&arrays, names::WRENCH, &data.wrench, &[f, pads, 6])?;
        put(&arrays, names::GRASP_POSE, &data.grasp_pose, &[7])?;
        Ok(arrays)
    }

    /// Rest positions of the nodes of a pad in its frame, m: (nodes, 3).
    fn pad_rest<'py>(&self, py: Python<'py>, object: &str) -> PyResult<Bound<'py, PyAny>> {
        let rest: Vec<f64> = self.object(object)?.pad.rest.iter().flat_map(|x| x.to_array()).collect();
        let n = rest.len() / 3;
        Ok(rest.to_pyarray(py).reshape([n, 3])?.into_any())
    }
}

impl DataSet {
    fn object(&self, name: &str) -> PyResult<&dataset::ObjectFile> {
        let names = || self.objects().join(", ");
        let found = self.0.objects.iter().find(|o| o.name == name);
        found.ok_or_else(|| refused(format!("the data set has no object {name:?}; it has: {}", names())))
    }
}

fn put<T: Element + Copy>(to: &Bound<'_, PyDict>, name: &str, numbers: &[T], shape: &[usize]) -> PyResult<()> {
    let whole: usize = shape.iter().product();
    if numbers.len() < whole {
        return Err(refused(format!("{name}: {} numbers for {shape:?}", numbers.len())));
    }
    to.set_item(name, numbers[..whole].to_pyarray(to.py()).reshape(shape.to_vec())?)
}

/// Makes part (i, n) of a data set, i from 0 to n - 1, and returns how many grasps ran; without a part what is left of it, and
/// closes it.
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
