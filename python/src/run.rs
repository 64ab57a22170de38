//! Simulated grasps, as NumPy arrays.

use crate::arrays::{flat, pads, put, surface, tactile};
use crate::progress::{Level, Progress};
use crate::refusal::refused;
use crate::supervise::watch;
use clap::ValueEnum;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use tactus::backend::simulate::Simulation;
use tactus::base::error::Result;
use tactus::base::machine::machine_threads;
use tactus::model::Model;
use tactus::record::{DynamicState, ErrorBound, Frame, PadFrame, names};
use tactus::scene::{Backend, Overrides, load_object};
use tactus::world::run::{Observer, Outcome};

/// Observer that stores the frames of each grasp (with indices `numbers`) and reports finished grasps.
struct Keep {
    numbers: Vec<usize>,
    frames: Vec<Mutex<Vec<Frame>>>,
    news: Arc<Progress>,
}

impl Observer for Keep {
    fn frame(&self, index: usize, frame: &Frame) -> Result<()> {
        let slot = self.numbers.iter().position(|number| *number == index).and_then(|at| self.frames[at].lock().ok());
        slot.into_iter().for_each(|mut frames| frames.push(frame.clone()));
        Ok(())
    }

    fn end(&self, _index: usize, _outcome: &Outcome) -> Result<()> {
        self.news.advance();
        Ok(())
    }
}

/// Run for Python: content of `run.json`, overall success, notices, wall time, pads, object, and the arrays of each
/// grasp.
type Run<'py> = (String, bool, Vec<String>, f64, Vec<Bound<'py, PyDict>>, Bound<'py, PyDict>, Vec<Bound<'py, PyDict>>);

/// Simulates grasps of a scene.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the names are Python's")]
pub fn run<'py>(
    py: Python<'py>,
    scene: String,
    object: Option<String>,
    backend: Option<&str>,
    model: Option<PathBuf>,
    force: Option<f64>,
    frames: Option<u64>,
    grasps: Vec<usize>,
    error_at_most: Option<f64>,
    extrapolate: bool,
    threads: Option<u64>,
    max_time: Option<f64>,
    sensitivity: bool,
    out: Option<PathBuf>,
    overwrite: bool,
    pictures: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Run<'py>> {
    let backend = backend.map(|name| {
        Backend::from_str(name, false)
            .map_err(|_| refused(format!("backend {name:?}; allowed: \"fem\", \"condensed\", \"gnn\"")))
    });
    let overrides = Overrides {
        backend: backend.transpose()?,
        model,
        error_at_most,
        extrapolate,
        force,
        frames,
        threads,
        max_time,
        no_pictures: !pictures,
    };
    let news = Arc::new(Progress::default());
    let (own, mut told) = (news.clone(), None);
    let work = move || -> Result<_> {
        let mut loaded = load_object(scene, object.as_deref())?;
        overrides.apply(&mut loaded.scene)?;
        let simulate = || {
            let simulation = Simulation::new(&loaded.scene, &grasps, overrides.threads.map(|n| n as usize))?;
            simulation.notices.iter().for_each(|notice| own.note(Level::Warning, notice));
            own.expect(simulation.grasps.len());
            let keep = Keep {
                numbers: simulation.grasps.iter().map(|(number, _)| *number).collect(),
                frames: simulation.grasps.iter().map(|_| Mutex::default()).collect(),
                news: own.clone(),
            };
            let writer = out.as_ref().map(|dir| simulation.record(dir, overwrite)).transpose()?;
            let simulated = simulation.run(writer, sensitivity, &keep)?;
            Ok((simulation, simulated, keep))
        };
        simulate().map_err(|e| loaded.locate_error(e))
    };
    let look = |py: Python<'py>| news.tell(py, progress.as_ref(), &mut told);
    let pool = threads.map_or_else(machine_threads, |n| n as usize);
    let (simulation, simulated, keep) = watch(py, Some(pool), look, work)?;
    let frames = keep.frames.into_iter().map(|f| f.into_inner().unwrap_or_default());
    let grasps = simulation.grasps.iter().zip(frames);
    let grasps = grasps.map(|((_, pose), frames)| grasp(py, &simulation.model, &pose.row(), &frames));
    Ok((
        simulated.report.to_json().map_err(refused)?,
        simulated.succeeded(),
        simulation.notices,
        simulated.wall_s,
        pads(py, &simulation.model)?,
        surface(py, &simulation.model.object.surface)?,
        grasps.collect::<PyResult<_>>()?,
    ))
}

/// Returns the arrays of a grasp by name, without those that are not recorded.
fn grasp<'py>(py: Python<'py>, model: &Model, pose: &[f64; 7], frames: &[Frame]) -> PyResult<Bound<'py, PyDict>> {
    let to = PyDict::new(py);
    let (count, pads) = (frames.len(), model.fingers.len());
    let sizes = |i: usize| (model.fingers[i].topology.rest.len(), model.fingers[i].topology.elements.len());
    if (1..pads).any(|i| sizes(i) != sizes(0)) {
        let text = "the two pads have different numbers of nodes, which cannot share one array; `tactus run` writes \
            `arrays.npz`";
        return Err(refused(text));
    }
    let topology = model.fingers.first().map(|f| &f.topology);
    let (nodes, tets) = topology.map_or((0, 0), |t| (t.rest.len(), t.elements.len()));
    let each = |name: &str, of: &dyn Fn(&Frame) -> Vec<f64>, shape: &[usize]| {
        let numbers: Vec<f64> = frames.iter().flat_map(of).collect();
        let shape: Vec<usize> = std::iter::once(count).chain(shape.iter().copied()).collect();
        put(&to, name, &numbers, &shape)
    };
    let each_pad = |name: &str, of: &dyn Fn(&PadFrame) -> Vec<f64>, shape: &[usize]| {
        let shape: Vec<usize> = std::iter::once(pads).chain(shape.iter().copied()).collect();
        each(name, &|f| f.pads.iter().flat_map(of).collect(), &shape)
    };
    put(&to, names::GRASP_POSE, pose, &[7])?;
    each(names::FORCE, &|f| vec![f.applied_force], &[])?;
    each(names::TIME, &|f| vec![f.time], &[])?;
    each(names::TRAVEL, &|f| f.travel.clone(), &[pads])?;
    let row = |p: glam::DVec3, q: glam::DQuat| vec![p.x, p.y, p.z, q.w, q.x, q.y, q.z];
    each(names::OBJECT_POSE, &|f| row(f.object_position, f.object_rotation), &[7])?;
    each(names::OBJECT_LOAD, &|f| flat(&[f.object_load.force, f.object_load.torque]), &[6])?;
    each_pad(names::POSITION, &|p| flat(&p.position), &[nodes, 3])?;
    each_pad(names::DISPLACEMENT, &|p| flat(&p.displacement), &[nodes, 3])?;
    each_pad(names::WRENCH, &|p| flat(&[p.wrench.force, p.wrench.torque]), &[6])?;
    if model.needs.contact_force {
        each_pad(names::CONTACT_FORCE, &|p| flat(&p.contact_force), &[nodes, 3])?;
    }
    let first = frames.first().and_then(|f| f.pads.first());
    if first.is_some_and(|p| !p.von_mises_node.is_empty()) {
        each_pad(names::VON_MISES, &|p| p.von_mises_node.clone(), &[nodes])?;
    }
    if first.is_some_and(|p| !p.von_mises_element.is_empty()) {
        each_pad(names::ELEMENT_VON_MISES, &|p| p.von_mises_element.clone(), &[tets])?;
    }
    if first.is_some_and(|p| !p.gap.is_empty()) {
        each_pad(names::GAP, &|p| p.gap.clone(), &[nodes])?;
    }
    if !frames.is_empty() && frames.iter().all(|f| f.error.is_some()) {
        for (k, name) in ErrorBound::NAMES.into_iter().enumerate() {
            each(name, &|f| f.error.iter().map(|e| e.to_array()[k]).collect(), &[])?;
        }
    }
    to.set_item("tactile", tactile(py, &frames.iter().map(|f| &f.tactile[..]).collect::<Vec<_>>())?)?;
    if model.needs.dynamic {
        let moving = |name: &str, of: &dyn Fn(&DynamicState) -> Vec<f64>, size: usize| {
            each(name, &|f| f.moving.iter().flat_map(of).collect(), &[size])
        };
        moving(names::HAND_POSE, &|m| row(m.hand_position, m.hand_rotation), 7)?;
        moving(names::OBJECT_MOTION, &|m| flat(&[m.velocity, m.spin]), 6)?;
        moving(names::GROUND_FORCE, &|m| flat(&[m.ground_force]), 3)?;
    }
    Ok(to)
}
