//! Inputs of the face network for the grasps of a scene, as NumPy arrays, for its PyTorch implementation.

use crate::arrays::{hands, put};
use crate::refusal::{raised, refused};
use crate::supervise::supervise;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::sync::Arc;
use tactus::base::error::Error;
use tactus::geometry::Pose;
use tactus::model::grasp::grasp_poses;
use tactus::net::infer::input_derivatives::{DerivativeDirection, GraspParameters, SceneInputs, weights};
use tactus::net::infer::inputs::Array;
use tactus::scene::{Overrides, load_object};

/// Returns the weights of a face network, given by folder or name, as the bytes of a safetensors file.
#[pyfunction]
pub fn face_weights<'py>(py: Python<'py>, model: &str) -> PyResult<Bound<'py, PyBytes>> {
    Ok(PyBytes::new(py, &weights(model.as_ref()).map_err(raised)?))
}

/// Inputs of a face network for the scene of one object.
#[pyclass(frozen)]
pub struct FaceInputs {
    inputs: Arc<SceneInputs>,
    poses: Vec<[f64; 7]>,
    threads: usize,
}

/// Arrays of grasps, their derivatives, indices of these grasps, and failure reasons of the others by index.
type Looked<'py> = (Bound<'py, PyDict>, Bound<'py, PyDict>, Vec<usize>, Bound<'py, PyDict>);

#[pymethods]
impl FaceInputs {
    #[new]
    fn new(
        py: Python<'_>,
        scene: String,
        object: Option<String>,
        model: String,
        frames: Option<u64>,
        extrapolate: bool,
        threads: usize,
    ) -> PyResult<Self> {
        let build = move || -> Result<_, Error> {
            let mut scene = load_object(scene, object.as_deref())?.scene;
            Overrides { frames, ..Overrides::default() }.apply(&mut scene)?;
            let inputs = SceneInputs::new(&scene, model.as_ref(), extrapolate)?;
            Ok((inputs, grasp_poses(&scene)?))
        };
        let (inputs, poses) = supervise(py, Some(threads), build)?;
        Ok(Self { inputs: Arc::new(inputs), poses: poses.iter().map(Pose::row).collect(), threads })
    }

    /// Returns the grasp poses of the scene (G, 7), the force at each load level (F), N, and friction.
    fn usual<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let ((force, friction), out) = (self.inputs.scene_forces_and_friction(), PyDict::new(py));
        put(&out, "poses", self.poses.as_flattened(), &[self.poses.len(), 7])?;
        put(&out, "force", &force, &[force.len()])?;
        out.set_item("friction", friction)?;
        Ok(out)
    }

    /// Returns the arrays shared by all grasps.
    fn pad<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (pad, out) = (self.inputs.pad(), PyDict::new(py));
        for array in &pad.indices {
            let numbers: Vec<i64> = array.numbers.iter().map(|i| i64::from(*i)).collect();
            put(&out, array.name, &numbers, &array.shape)?;
        }
        pad.numbers.iter().try_for_each(|array| put(&out, array.name, &array.numbers, &array.shape))?;
        Ok(out)
    }

    /// Returns the arrays (G, ...) of the grasps at `poses` (G, 7) under `force` (G, F) with `friction` (G); their
    /// derivatives (G, changes, ...) along the changes with these indices; the indices of the grasps that succeeded,
    /// and the failure reasons of the others by index.
    fn grasps<'py>(
        &self,
        py: Python<'py>,
        poses: PyReadonlyArray2<'py, f64>,
        force: PyReadonlyArray2<'py, f64>,
        friction: PyReadonlyArray1<'py, f64>,
        changes: Vec<usize>,
    ) -> PyResult<Looked<'py>> {
        let changes = changes.into_iter().map(|k| DerivativeDirection::ALL.get(k).copied());
        let changes: Vec<DerivativeDirection> =
            changes.collect::<Option<_>>().ok_or_else(|| refused("changes: 0 to 7"))?;
        let (poses, force, friction) = (hands(&poses)?, force.as_array(), friction.as_array());
        let grips = poses.into_iter().zip(force.rows()).zip(friction);
        let grips: Vec<GraspParameters> = grips
            .map(|((pose, force), friction)| GraspParameters { pose, force: force.to_vec(), friction: *friction })
            .collect();
        let inputs = self.inputs.clone();
        let answers = supervise(py, Some(self.threads), move || inputs.grasps(&grips, &changes))?;
        let (mut known, mut own, failed) = (Vec::new(), Vec::new(), PyDict::new(py));
        for (grasp, answer) in answers.into_iter().enumerate() {
            match answer {
                Ok(answer) => {
                    known.push(grasp);
                    own.push(answer);
                }
                Err(reason) => failed.set_item(grasp, reason.to_string())?,
            }
        }
        let stacked = |which: usize| -> PyResult<Bound<'py, PyDict>> {
            let out = PyDict::new(py);
            let first: &[Array<f32>] = own.first().map_or(&[], |grasp| &grasp[which]);
            for (k, array) in first.iter().enumerate() {
                let numbers: Vec<f32> = own.iter().flat_map(|grasp| &grasp[which][k].numbers).copied().collect();
                let shape: Vec<usize> = std::iter::once(own.len()).chain(array.shape.iter().copied()).collect();
                put(&out, array.name, &numbers, &shape)?;
            }
            Ok(out)
        };
        Ok((stacked(0)?, stacked(1)?, known, failed))
    }
}
