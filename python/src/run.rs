//! Scenes for Python: what they resolve to, and what their grasps do.

use crate::refused;
use crate::supervise::supervise;
use numpy::{PyArrayMethods, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Mutex;
use tactus::backend::choose;
use tactus::error::Result;
use tactus::grasp::poses_of;
use tactus::model::Model;
use tactus::record::{ErrorBound, Frame, names};
use tactus::run::{Observer, run_grasps};
use tactus::scene::{Gnn, StepperChoice, load_object, load_set, to_ron};

/// Names of the objects of a scene file.
#[pyfunction]
pub fn objects(py: Python<'_>, scene: String) -> PyResult<Vec<String>> {
    let set = supervise(py, Some(1), || load_set(scene))?;
    Ok(set.scenes.iter().map(|s| s.name.as_str().to_string()).collect())
}

/// The scene of one object as RON, all defaults written out.
#[pyfunction]
pub fn resolved(scene: &str, object: Option<&str>) -> PyResult<String> {
    to_ron(&load_object(scene, object).map_err(refused)?.scene).map_err(refused)
}

/// Keeps the frames of every grasp.
struct Keep(Vec<Mutex<Vec<Frame>>>);

impl Observer for Keep {
    fn frame(&self, index: usize, frame: &Frame) -> Result<()> {
        if let Ok(mut frames) = self.0[index].lock() {
            frames.push(frame.clone());
        }
        Ok(())
    }
}

/// Simulates all grasps of a scene: a dictionary of arrays for each.
#[pyfunction]
pub fn run<'py>(
    py: Python<'py>,
    scene: String,
    object: Option<String>,
    model: Option<String>,
    threads: usize,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let simulate = move || -> Result<_> {
        let mut scene = load_object(scene, object.as_deref())?.scene;
        if let Some(model) = model {
            scene.stepper = StepperChoice::Gnn(Gnn::new(model));
        }
        let (built, stepper) = (Model::build(&scene)?, choose(&scene)?);
        let poses: Vec<_> = poses_of(&scene)?.into_iter().enumerate().collect();
        let keep = Keep(poses.iter().map(|_| Mutex::default()).collect());
        let outcomes = run_grasps(&built, stepper.as_ref(), &poses, threads.max(1), &keep)?;
        let frames = keep.0.into_iter().map(|f| f.into_inner().unwrap_or_default());
        Ok(outcomes.into_iter().zip(frames).collect::<Vec<_>>())
    };
    let done = supervise(py, Some(threads), simulate)?;
    let grasp = |(outcome, frames): (tactus::run::Outcome, Vec<Frame>)| {
        let grasp = PyDict::new(py);
        let summary = &outcome.summary;
        grasp.set_item("status", summary.status.word())?;
        grasp.set_item("reason", summary.reason.clone())?;
        grasp.set_item("wall_s", summary.wall_s)?;
        let (count, pads) = (frames.len(), frames.first().map_or(0, |f| f.pads.len()));
        let put = |name: &str, numbers: Vec<f64>, shape: &[usize]| -> PyResult<()> {
            let shape: Vec<usize> = std::iter::once(count).chain(shape.iter().copied()).collect();
            // What the scene does not record is left out.
            if numbers.len() == shape.iter().product::<usize>() && !numbers.is_empty() {
                grasp.set_item(name, numbers.to_pyarray(py).reshape(shape)?)?;
            }
            Ok(())
        };
        let nodes = frames.first().and_then(|f| f.pads.first()).map_or(0, |p| p.position.len());
        let of_pads = |pick: &dyn Fn(&tactus::record::PadFrame) -> Vec<f64>| {
            frames.iter().flat_map(|f| f.pads.iter().flat_map(pick)).collect::<Vec<f64>>()
        };
        let flat = |v: &[glam::DVec3]| v.iter().flat_map(|x| x.to_array()).collect::<Vec<f64>>();
        put(names::FORCE, frames.iter().map(|f| f.applied_force).collect(), &[])?;
        put(names::TRAVEL, frames.iter().flat_map(|f| f.travel.clone()).collect(), &[pads])?;
        for (k, name) in ErrorBound::NAMES.into_iter().enumerate() {
            put(name, frames.iter().filter_map(|f| Some(f.error?.to_array()[k])).collect(), &[])?;
        }
        let pose = |f: &Frame| {
            let (p, q) = (f.object_position, f.object_rotation);
            [p.x, p.y, p.z, q.w, q.x, q.y, q.z]
        };
        put(names::OBJECT_POSE, frames.iter().flat_map(pose).collect(), &[7])?;
        let load = |f: &Frame| flat(&[f.object_load.force, f.object_load.torque]);
        put(names::OBJECT_LOAD, frames.iter().flat_map(load).collect(), &[6])?;
        put(names::POSITION, of_pads(&|p| flat(&p.position)), &[pads, nodes, 3])?;
        put(names::DISPLACEMENT, of_pads(&|p| flat(&p.displacement)), &[pads, nodes, 3])?;
        put(names::CONTACT_FORCE, of_pads(&|p| flat(&p.contact_force)), &[pads, nodes, 3])?;
        put(names::VON_MISES, of_pads(&|p| p.von_mises_node.clone()), &[pads, nodes])?;
        put(names::WRENCH, of_pads(&|p| flat(&[p.wrench.force, p.wrench.torque])), &[pads, 6])?;
        Ok(grasp)
    };
    done.into_iter().map(grasp).collect()
}
