//! Predictions of a network for many grasps, as NumPy arrays.

use crate::arrays::{hands, pads, surface};
use crate::supervise::supervise;
use numpy::{PyArrayMethods, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use tactus::base::error::Error;
use tactus::base::machine::machine_threads;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::net::DEFAULT_MODEL;
use tactus::net::infer::arrays::each_array;
use tactus::net::infer::predict::Predictor;
use tactus::scene::{Overrides, load_object};

/// Predictions for Python: arrays, pads, object, failure reasons by grasp index, and notices.
type Predictions<'py> =
    (Bound<'py, PyDict>, Vec<Bound<'py, PyDict>>, Bound<'py, PyDict>, Bound<'py, PyDict>, Vec<String>);

/// Predicts the grasps of a scene, or those at `poses`.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the names are Python's")]
pub fn predict<'py>(
    py: Python<'py>,
    scene: String,
    object: Option<String>,
    model: Option<PathBuf>,
    poses: Option<PyReadonlyArray2<'py, f64>>,
    force: Option<f64>,
    frames: Option<u64>,
    extrapolate: bool,
    threads: Option<usize>,
) -> PyResult<Predictions<'py>> {
    let given = poses.map(|poses| hands(&poses)).transpose()?;
    let answer = move || -> Result<_, Error> {
        let mut loaded = load_object(scene, object.as_deref())?;
        let overrides = Overrides { force, frames, ..Overrides::default() };
        overrides.apply(&mut loaded.scene)?;
        let predict = || {
            let scene = &loaded.scene;
            let model = model.as_deref().or(scene.stepper.model()).unwrap_or(DEFAULT_MODEL.as_ref());
            let predictor = Predictor::open(model)?;
            let model = Model::build(&scene.without_finer_mesh())?;
            let poses = match given {
                Some(poses) => poses,
                None => grasp_poses(scene)?,
            };
            let extrapolate = extrapolate || scene.stepper.extrapolates();
            let answers = predictor.predict_batch(&model, &poses, extrapolate)?;
            let loads: Vec<_> =
                predictor.answerable_loads(&model, extrapolate).into_iter().map(|(_, load)| load).collect();
            let mut arrays = Vec::new();
            each_array(&model, &loads, &answers, |name, shape, numbers| {
                arrays.push((name.to_string(), shape.to_vec(), numbers));
                Ok::<(), Error>(())
            })?;
            let reason = |answer: &Result<_, Error>| answer.as_ref().err().map(Error::to_string);
            let failed = answers.iter().map(reason).enumerate().filter_map(|(i, reason)| Some((i, reason?)));
            let notices = predictor.notices(&model, extrapolate);
            Ok((model, arrays, failed.collect::<Vec<_>>(), notices))
        };
        predict().map_err(|e| loaded.locate_error(e))
    };
    let (model, arrays, failed, notices) = supervise(py, Some(threads.unwrap_or_else(machine_threads)), answer)?;
    let (out, tactile, reasons) = (PyDict::new(py), PyDict::new(py), PyDict::new(py));
    let seen: Vec<String> = model.sensors.iter().map(|sense| sense.spec().file_name()).collect();
    for (name, shape, numbers) in arrays {
        let to = if seen.contains(&name) { &tactile } else { &out };
        to.set_item(name, numbers.to_pyarray(py).reshape(shape)?)?;
    }
    out.set_item("tactile", tactile)?;
    failed.into_iter().try_for_each(|(grasp, reason)| reasons.set_item(grasp, reason))?;
    Ok((out, pads(py, &model)?, surface(py, &model.object.surface)?, reasons, notices))
}
