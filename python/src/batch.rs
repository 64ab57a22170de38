//! `tactus::env::BatchEnv` for Python: writes into arrays that the caller owns, with the interpreter's lock released.

use crate::refused;
use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use tactus::env::{Autoreset, BatchConfig, BatchEnv};
use tactus::scene::{Gnn, Stepper, load_set};

/// Environments of one scene.
#[pyclass]
pub struct Batch {
    env: BatchEnv,
    names: Vec<String>,
}

/// An array to write observations to.
type Out<'py> = PyReadwriteArray1<'py, f32>;

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (scene, num_envs, seed, autoreset, max_steps, threads, objects, first_env, model))]
    #[allow(clippy::too_many_arguments, reason = "the names are Python's")]
    fn new(
        py: Python<'_>,
        scene: &str,
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
        let open = || {
            let mut set = load_set(scene)?.scenes;
            if let Some(model) = model {
                set.iter_mut().for_each(|s| s.scene.stepper = Stepper::Gnn(Gnn { model: model.clone().into() }));
            }
            BatchEnv::new(&set, config)
        };
        let env = py.detach(open).map_err(refused)?;
        let names = env.observation_spec().into_iter().map(|s| s.name).collect();
        Ok(Self { env, names })
    }

    /// (name, shape, unit, low, high) of every observation of one environment.
    fn observation_spec(&self) -> Vec<(String, Vec<usize>, String, f32, f32)> {
        let spec = self.env.observation_spec().into_iter();
        spec.map(|s| (s.name, s.shape, s.unit, s.low, s.high)).collect()
    }

    /// Numbers of an action.
    fn action_size(&self) -> usize {
        self.env.action_spec().size()
    }

    fn reset(&mut self, py: Python<'_>, seed: Option<u64>, mask: Option<Vec<bool>>, out: Vec<Out>) -> PyResult<()> {
        let env = &mut self.env;
        py.detach(|| env.reset(seed, mask.as_deref()).map(|_| ())).map_err(refused)?;
        self.write(out, false)
    }

    /// Writes observations, then reward, terminated and truncated (as 0 and 1).
    #[allow(clippy::too_many_arguments, reason = "one array each")]
    fn step(
        &mut self,
        py: Python<'_>,
        actions: PyReadonlyArray1<f32>,
        out: Vec<Out>,
        mut reward: Out,
        mut terminated: PyReadwriteArray1<bool>,
        mut truncated: PyReadwriteArray1<bool>,
    ) -> PyResult<()> {
        let (env, actions) = (&mut self.env, actions.as_slice()?.to_vec());
        let view = py.detach(|| env.step(&actions)).map_err(refused)?;
        reward.as_slice_mut()?.copy_from_slice(view.reward());
        terminated.as_slice_mut()?.copy_from_slice(view.terminated());
        truncated.as_slice_mut()?.copy_from_slice(view.truncated());
        self.write(out, false)
    }

    /// Writes the last observations of the episodes that the step ended and followed by new ones.
    fn final_obs(&self, out: Vec<Out>) -> PyResult<()> {
        self.write(out, true)
    }

    /// What the rewards were made of: (held, slip, slipped, margin, stress, force, load) per environment.
    fn facts(&self) -> Vec<(bool, f64, f64, f64, f64, f64, f64)> {
        let facts = self.env.view().facts().iter();
        facts.map(|f| (f.held, f.slip, f.slipped, f.margin, f.stress, f.force, f.load)).collect()
    }

    /// Why an environment has no state for this step; None where it has.
    fn faults(&self) -> Vec<Option<String>> {
        (0..self.env.num_envs()).map(|i| self.env.view().fault(i).map(str::to_string)).collect()
    }

    /// Name of the object that each environment holds.
    fn held_objects(&self) -> Vec<Option<String>> {
        (0..self.env.num_envs()).map(|i| self.env.episode(i).map(|(name, _)| name.to_string())).collect()
    }

    fn save(&self, env: usize) -> PyResult<String> {
        self.check(env)?;
        serde_json::to_string(&self.env.save(env)).map_err(refused)
    }

    fn restore(&mut self, py: Python<'_>, env: usize, snapshot: &str, out: Vec<Out>) -> PyResult<()> {
        self.check(env)?;
        let snapshot = serde_json::from_str(snapshot).map_err(refused)?;
        let batch = &mut self.env;
        py.detach(|| {
            batch.restore(env, &snapshot);
        });
        self.write(out, false)
    }
}

impl Batch {
    fn check(&self, env: usize) -> PyResult<()> {
        let n = self.env.num_envs();
        if env < n { Ok(()) } else { Err(refused(format!("environment {env} of {n}"))) }
    }

    fn write(&self, out: Vec<Out>, last: bool) -> PyResult<()> {
        let view = self.env.view();
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
