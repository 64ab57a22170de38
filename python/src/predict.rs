//! A network's answers to many grasps, as numpy arrays.

use crate::refused;
use crate::supervise::supervise;
use numpy::{PyArrayMethods, PyReadonlyArray2, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tactus::error::Error;
use tactus::grasp::poses_of;
use tactus::gripper::GraspPose;
use tactus::model::Model;
use tactus::net::infer::arrays::each_array;
use tactus::net::infer::predict::Predictor;
use tactus::scene::load_object;

fn pose(row: &[f64]) -> GraspPose {
    let GraspPose { position, rotation } = GraspPose::from_row(row);
    GraspPose { position, rotation: rotation.normalize() }
}

/// Predicts the grasps of a scene, or at `poses`: a dictionary of arrays over all grasps that have an answer, and `failed`, the reason of
/// each that has none by its number.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn predict<'py>(
    py: Python<'py>,
    scene: String,
    object: Option<String>,
    model: String,
    poses: Option<PyReadonlyArray2<'py, f64>>,
    frames: Option<u64>,
    extrapolate: bool,
    threads: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let given = poses.map(|poses| poses.as_array().rows().into_iter().map(|row| row.to_vec()).collect::<Vec<_>>());
    let wrong =
        |row: &Vec<f64>| row.len() != 7 || row.iter().any(|v| !v.is_finite()) || row[3..].iter().all(|v| *v == 0.0);
    if given.iter().flatten().any(wrong) {
        return Err(refused(
            "poses: rows of 7 finite numbers are needed: px py pz qw qx qy qz of the hand in the object frame, no quaternion zero",
        ));
    }
    let answer = move || -> Result<_, Error> {
        let mut scene = load_object(scene, object.as_deref())?.scene;
        if let Some(frames) = frames {
            scene.loading.set_frames(frames).map_err(|m| Error::Scene(format!("error: frames: {m}")))?;
        }
        let predictor = Predictor::open(model.as_ref())?;
        let model = Model::build(&scene.on_own_mesh())?;
        let poses = match given {
            Some(rows) => rows.iter().map(|row| pose(row)).collect(),
            None => poses_of(&scene)?,
        };
        let answers = predictor.many(&model, &poses, extrapolate || scene.stepper.extrapolates())?;
        let mut arrays = Vec::new();
        each_array(&model, &answers, |name, shape, numbers| {
            arrays.push((name.to_string(), shape.to_vec(), numbers));
            Ok::<(), Error>(())
        })?;
        let failed = answers.iter().enumerate().filter_map(|(i, answer)| Some((i, answer.as_ref().err()?.to_string())));
        Ok((arrays, failed.collect::<Vec<_>>()))
    };
    let (arrays, failed) = supervise(py, Some(threads), answer)?;
    let out = PyDict::new(py);
    for (name, shape, numbers) in arrays {
        out.set_item(name, numbers.to_pyarray(py).reshape(shape)?)?;
    }
    out.set_item(
        "grasp",
        out.get_item("grasp")?.map(|numbers| numbers.call_method1("astype", ("int64",))).transpose()?,
    )?;
    let reasons = PyDict::new(py);
    failed.into_iter().try_for_each(|(grasp, reason)| reasons.set_item(grasp, reason))?;
    out.set_item("failed", reasons)?;
    Ok(out)
}
