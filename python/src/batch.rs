//! `tactus::env::BatchEnv` for Python: writes into arrays owned by the caller; the GIL is released during work.

use crate::refusal::refused;
use crate::supervise::supervise;
use numpy::{PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadwriteArray1, ToPyArray};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::{Arc, Mutex, MutexGuard};
use tactus::env::{Autoreset, BatchConfig, BatchEnv, Snapshot};
use tactus::scene::{Gnn, StepperChoice, load_set};

/// Batch of environments of one scene.
#[pyclass(frozen)]
pub struct Batch {
    env: Arc<Mutex<BatchEnv>>,
    names: Vec<String>,
    num_envs: usize,
}

/// Output array.
type Out<'py> = PyReadwriteArray1<'py, f32>;

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (scene, num_envs, seed, autoreset, max_steps, threads, objects, first_env, model))]
    #[allow(clippy::too_many_arguments, reason = "the names are Python's")]
    fn new(
        py: Python<'_>,
        scene: String,
        num_envs: usize,
        seed: u64,
        autoreset: &str,
        max_steps: Option<usize>,
        threads: Option<usize>,
        objects: Option<Vec<String>>,
        first_env: u64,
        model: Option<String>,
    ) -> PyResult<Self> {
        let autoreset = match autoreset {
            "NextStep" => Autoreset::NextStep,
            "SameStep" => Autoreset::SameStep,
            "Disabled" => Autoreset::Disabled,
            other => return Err(refused(format!("autoreset {other:?}; allowed: NextStep, SameStep, Disabled"))),
        };
        let config = BatchConfig { num_envs, first_env, seed, autoreset, max_steps, threads, objects };
        let open = move || {
            let mut set = load_set(scene)?.scenes;
            if let Some(model) = model {
                set.iter_mut().for_each(|s| s.scene.stepper = StepperChoice::Gnn(Gnn::new(model.clone())));
            }
            BatchEnv::new(&set, config)
        };
        let env = supervise(py, None, open)?;
        let names = env.observation_spec().into_iter().map(|s| s.name).collect();
        Ok(Self { env: Arc::new(Mutex::new(env)), names, num_envs })
    }

    /// Returns (name, shape, unit, low, high) of every observation of one environment.
    fn observation_spec(&self) -> PyResult<Vec<(String, Vec<usize>, String, f32, f32)>> {
        let spec = self.lock()?.observation_spec().into_iter();
        Ok(spec.map(|s| (s.name, s.shape, s.unit, s.low, s.high)).collect())
    }

    /// Returns the number of components of an action.
    fn action_size(&self) -> PyResult<usize> {
        Ok(self.lock()?.action_spec().size())
    }

    /// Starts the first episodes of `seeds` (one per environment; None starts the next episode) or of `seed` (for the
    /// whole batch); without seeds the next episodes.
    fn reset(
        &self,
        py: Python<'_>,
        seed: Option<u64>,
        seeds: Option<Vec<Option<u64>>>,
        mask: Option<Vec<bool>>,
        out: Vec<Out>,
    ) -> PyResult<()> {
        self.work(py, move |env| {
            let mask = mask.as_deref();
            match seeds {
                Some(seeds) => env.reset_each(&seeds, mask).map(drop),
                None => env.reset(seed, mask).map(drop),
            }
        })?;
        self.write(out, false)
    }

    /// Takes one step; writes observations, reward, terminated and truncated.
    #[allow(clippy::too_many_arguments, reason = "one array each")]
    fn step(
        &self,
        py: Python<'_>,
        actions: PyReadonlyArray1<f32>,
        out: Vec<Out>,
        mut reward: Out,
        mut terminated: PyReadwriteArray1<bool>,
        mut truncated: PyReadwriteArray1<bool>,
    ) -> PyResult<()> {
        let actions = actions.as_slice()?.to_vec();
        self.work(py, move |env| env.step(&actions).map(drop))?;
        let env = self.lock()?;
        reward.as_slice_mut()?.copy_from_slice(env.view().reward());
        terminated.as_slice_mut()?.copy_from_slice(env.view().terminated());
        truncated.as_slice_mut()?.copy_from_slice(env.view().truncated());
        drop(env);
        self.write(out, false)
    }

    /// Writes the final observations of the episodes that ended in the last step.
    fn final_obs(&self, out: Vec<Out>) -> PyResult<()> {
        self.write(out, true)
    }

    /// Returns (held, slip, slipped, margin, stress, force, load) per environment, from which rewards are computed.
    fn info(&self) -> PyResult<Vec<(bool, f64, f64, f64, f64, f64, f64)>> {
        let env = self.lock()?;
        let info = env.view().info().iter();
        Ok(info.map(|i| (i.held, i.slip, i.accumulated_slip, i.margin, i.stress, i.force, i.load)).collect())
    }

    /// Returns, per environment, the reason why there is no state for this step; None if there is one.
    fn faults(&self) -> PyResult<Vec<Option<String>>> {
        let env = self.lock()?;
        Ok((0..self.num_envs).map(|i| env.view().fault(i).map(str::to_string)).collect())
    }

    /// Returns the object name of each environment.
    fn held_objects(&self) -> PyResult<Vec<Option<String>>> {
        let env = self.lock()?;
        Ok((0..self.num_envs).map(|i| env.episode(i).map(|(name, _)| name.to_string())).collect())
    }

    /// Returns the seed of the episodes of each environment.
    fn seeds(&self) -> PyResult<Vec<u64>> {
        let env = self.lock()?;
        Ok((0..self.num_envs).map(|i| env.key(i).seed).collect())
    }

    /// Returns, per environment, true if it has been reset.
    fn begun(&self) -> PyResult<Vec<bool>> {
        let env = self.lock()?;
        Ok((0..self.num_envs).map(|i| env.has_started(i)).collect())
    }

    fn save<'py>(&self, py: Python<'py>, env: usize) -> PyResult<Bound<'py, PyBytes>> {
        self.check(env)?;
        let saved = self.lock()?.save(env).map_err(refused)?;
        Ok(PyBytes::new(py, &saved.to_bytes().map_err(refused)?))
    }

    fn restore(&self, py: Python<'_>, env: usize, snapshot: &[u8], out: Vec<Out>) -> PyResult<()> {
        self.check(env)?;
        let snapshot = Snapshot::from_bytes(snapshot).map_err(refused)?;
        self.work(py, move |batch| batch.restore(env, &snapshot).map(drop))?;
        self.write(out, false)
    }

    /// Renders an environment: (height, width, 3).
    fn render<'py>(&self, py: Python<'py>, env: usize) -> PyResult<Bound<'py, PyArray3<u8>>> {
        self.check(env)?;
        let picture = self.work(py, move |batch| batch.render(env))?;
        let (height, width) = (picture.height() as usize, picture.width() as usize);
        // The alpha channel is always opaque.
        let rgb: Vec<u8> = picture.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        rgb.to_pyarray(py).reshape([height, width, 3])
    }
}

impl Batch {
    /// Runs `work` on the environments in a thread that signals can interrupt.
    fn work<T, E>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut BatchEnv) -> Result<T, E> + Send + 'static,
    ) -> PyResult<T>
    where
        T: Send + 'static,
        E: std::fmt::Display + Send + 'static,
    {
        let env = self.env.clone();
        supervise(py, None, move || match env.lock() {
            Ok(mut env) => work(&mut env).map_err(|e| e.to_string()),
            Err(_) => Err(BROKEN.to_string()),
        })
    }

    fn lock(&self) -> PyResult<MutexGuard<'_, BatchEnv>> {
        self.env.lock().map_err(|_| PyRuntimeError::new_err(BROKEN))
    }

    fn check(&self, env: usize) -> PyResult<()> {
        let n = self.num_envs;
        if env < n { Ok(()) } else { Err(refused(format!("environment {env} of {n}"))) }
    }

    fn write(&self, out: Vec<Out>, last: bool) -> PyResult<()> {
        let env = self.lock()?;
        let view = env.view();
        for (name, mut out) in self.names.iter().zip(out) {
            let from = if last { view.final_obs(name) } else { view.obs(name) }.unwrap_or_default();
            let to = out.as_slice_mut()?;
            if to.len() != from.len() {
                return Err(refused(format!("{name}: an array of {} numbers for {}", to.len(), from.len())));
            }
            to.copy_from_slice(from);
        }
        Ok(())
    }
}

/// Message about environments whose lock was poisoned by a panic.
const BROKEN: &str = "an earlier call caused an internal error of tactus; create the environments again";
