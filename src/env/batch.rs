//! Batches of environments that are stepped together.

use super::action;
use super::config::{Autoreset, BatchConfig};
use super::draw::{EpisodeKey, EpisodeParameters};
use super::environment::Env;
use super::pool::Pool;
use super::reward::StepInfo;
use super::shared::EnvShared;
use super::snapshot::Snapshot;
use super::view::{EnvArray, Outputs, StepError, StepView};
use base::error::{Error, Result};
use base::interrupt;
use base::number::format_count;
use model::sensors::ArraySpec;
use rayon::prelude::*;
use record::render::Pixmap;
use scene::{NamedScene, load_set};
use std::path::Path;
use world::environment::Environment;

/// Batch of environments of one scene.
pub struct BatchEnv {
    shared: EnvShared,
    envs: Vec<Env>,
    config: BatchConfig,
    pool: Pool,
    outputs: Outputs,
}

impl BatchEnv {
    /// Creates a batch of environments of the scene file at `path`.
    ///
    /// # Errors
    /// Fails if the file cannot be loaded, and as [`BatchEnv::new`] does.
    pub fn open(path: impl AsRef<Path>, config: BatchConfig) -> Result<Self> {
        Self::new(&load_set(path)?.scenes, config)
    }

    /// Creates a batch of environments of the scenes of one file: one scene per object, from which every episode draws
    /// one.
    ///
    /// # Errors
    /// Fails for a scene without a task, and for models that cannot be built or that the backend rejects.
    pub fn new(set: &[NamedScene], config: BatchConfig) -> Result<Self> {
        if config.num_envs == 0 {
            return Err(Error::Start("a batch has at least one environment".into()));
        }
        let mut pool = Pool::new(config.threads)?;
        let open = || {
            let shared = EnvShared::new(set, config.objects.as_deref(), config.max_steps)?;
            for kind in &shared.kinds {
                for variant in &kind.variants {
                    interrupt::check()?;
                    Environment::new(&variant.model, shared.stepper.as_ref(), kind.poses[0])?;
                }
            }
            Ok::<_, Error>(shared)
        };
        // In the own pool, because the global thread pool does not exist in a forked process.
        let shared = pool.install(open)??;
        let n = config.num_envs;
        let key = |i: usize| EpisodeKey { seed: config.seed, env: config.first_env + i as u64, episode: 0 };
        let array = |spec: ArraySpec| {
            let zeros = vec![0.0; n * spec.size()];
            EnvArray { spec, now: zeros.clone(), last: zeros }
        };
        let outputs = Outputs {
            arrays: shared.sensors.iter().map(|s| array(s.spec())).collect(),
            reward: vec![0.0; n],
            terminated: vec![false; n],
            truncated: vec![false; n],
            ended: vec![false; n],
            faults: vec![None; n],
            info: vec![StepInfo::default(); n],
        };
        Ok(Self { envs: (0..n).map(|i| Env::new(key(i))).collect(), shared, config, pool, outputs })
    }

    /// Replaces the reward of the scene by a user-defined function.
    pub fn with_reward(mut self, reward: impl Fn(&StepInfo) -> f64 + Send + Sync + 'static) -> Self {
        self.shared.reward_function = Some(Box::new(reward));
        self
    }

    /// Returns the number of environments.
    pub fn num_envs(&self) -> usize {
        self.envs.len()
    }

    /// Returns the settings of the batch.
    pub fn config(&self) -> &BatchConfig {
        &self.config
    }

    /// Returns the specifications of the observations of one environment.
    pub fn observation_spec(&self) -> Vec<ArraySpec> {
        self.shared.sensors.iter().map(|s| s.spec()).collect()
    }

    /// Returns the specification of the action of one environment.
    pub fn action_spec(&self) -> ArraySpec {
        action::spec(&self.shared.task)
    }

    /// Starts the next episode of the environments in `mask` (None is all), or their first episode under `seed` if
    /// given.
    ///
    /// # Errors
    /// Fails if the length of the mask does not match, and on an interruption.
    pub fn reset(&mut self, seed: Option<u64>, mask: Option<&[bool]>) -> std::result::Result<StepView<'_>, StepError> {
        let first = self.config.first_env;
        self.begin(mask, |i| seed.map(|seed| EpisodeKey { seed, env: first + i as u64, episode: 0 }))
    }

    /// Starts episodes with one seed per environment, in the environments of `mask` (None is all). A seed starts the
    /// first episode of a single-environment batch with this seed; None starts the next episode.
    ///
    /// # Errors
    /// Fails if the length of the seeds or the mask does not match, and on an interruption.
    pub fn reset_each(
        &mut self,
        seeds: &[Option<u64>],
        mask: Option<&[bool]>,
    ) -> std::result::Result<StepView<'_>, StepError> {
        if seeds.len() != self.envs.len() {
            let message =
                format!("{} for {}", format_count(seeds.len(), "seed"), format_count(self.envs.len(), "environment"));
            return Err(StepError::call(message));
        }
        self.begin(mask, |i| seeds[i].map(|seed| EpisodeKey { seed, env: 0, episode: 0 }))
    }

    /// Starts the episodes `key(i)` in the environments of `mask`, or the next episode where `key(i)` is None.
    fn begin(
        &mut self,
        mask: Option<&[bool]>,
        key: impl Fn(usize) -> Option<EpisodeKey> + Sync,
    ) -> std::result::Result<StepView<'_>, StepError> {
        if let Some(mask) = mask
            && mask.len() != self.envs.len()
        {
            let message = format!(
                "the mask has {} for {}",
                format_count(mask.len(), "entry"),
                format_count(self.envs.len(), "environment")
            );
            return Err(StepError::call(message));
        }
        let Self { shared, envs, pool, .. } = self;
        let begun = pool.install(|| {
            envs.par_iter_mut().enumerate().with_max_len(1).for_each(|(i, env)| {
                if mask.is_none_or(|mask| mask[i]) && !interrupt::requested() {
                    // Before the first reset, the key is that of the episode to start.
                    let fresh = env.output.obs.is_empty();
                    let next = if fresh { env.key } else { env.key.next() };
                    env.begin(shared, key(i).unwrap_or(next));
                }
            });
        });
        self.finish_parallel(begun)?;
        self.collect();
        self.outputs.ended.fill(false);
        Ok(StepView(&self.outputs))
    }

    /// Takes one step of every environment; `actions` is (environments, action), row-major.
    ///
    /// # Errors
    /// Fails if the length of `actions` does not match, if a number is not finite, and if an environment requires a
    /// reset; the state is then unchanged. Fails on an interruption; all episodes are then discarded.
    pub fn step(&mut self, actions: &[f32]) -> std::result::Result<StepView<'_>, StepError> {
        let size = action::size(&self.shared.task);
        if actions.len() != size * self.envs.len() {
            let (found, n) = (actions.len(), self.envs.len());
            return Err(StepError::call(format!(
                "{} for {} with {size} each",
                format_count(found, "number"),
                format_count(n, "environment")
            )));
        }
        let mode = self.config.autoreset;
        for (i, (env, numbers)) in self.envs.iter().zip(actions.chunks_exact(size)).enumerate() {
            if let Some(bad) = numbers.iter().find(|v| !v.is_finite()) {
                return Err(StepError::of(i, format!("its action contains {bad}; allowed: -1 to 1")));
            }
            if env.output.obs.is_empty() {
                return Err(StepError::of(i, "steps before its first reset; call `reset`"));
            }
            if env.ended && mode == Autoreset::Disabled {
                return Err(StepError::of(i, "its episode has ended; reset it, or choose another autoreset"));
            }
        }
        let Self { shared, envs, pool, .. } = self;
        let stepped = pool.install(|| {
            envs.par_iter_mut().zip(actions.par_chunks_exact(size)).with_max_len(1).for_each(
                |(env, numbers)| match mode {
                    _ if interrupt::requested() => {}
                    Autoreset::NextStep if env.ended => env.begin(shared, env.key.next()),
                    Autoreset::SameStep => {
                        env.advance(shared, numbers);
                        env.autoreset(shared);
                    }
                    _ => env.advance(shared, numbers),
                },
            );
        });
        self.finish_parallel(stepped)?;
        self.collect();
        Ok(StepView(&self.outputs))
    }

    /// Returns the results of the last reset, step or restore.
    pub fn view(&self) -> StepView<'_> {
        StepView(&self.outputs)
    }

    /// Saves the state of environment `env`, which can be restored in any batch of the same scene.
    ///
    /// # Errors
    /// Fails if the state cannot be serialised.
    pub fn save(&self, env: usize) -> Result<Snapshot> {
        self.envs[env].save(&self.shared)
    }

    /// Restores environment `env` bit for bit to the state saved in `snapshot`.
    ///
    /// # Errors
    /// Fails for an environment that does not exist, and for a snapshot that is damaged or of another scene; the state
    /// is then unchanged.
    pub fn restore(&mut self, env: usize, snapshot: &Snapshot) -> std::result::Result<StepView<'_>, StepError> {
        let n = self.envs.len();
        let Self { shared, envs, pool, .. } = self;
        let wanted = envs.get_mut(env).ok_or_else(|| StepError::call(format!("environment {env} of {n}")))?;
        snapshot.check(&shared.identity).map_err(|message| StepError::of(env, message))?;
        let restored = pool.install(|| wanted.restore(shared, snapshot)).map_err(|e| StepError::call(e.to_string()))?;
        restored.map_err(|e| StepError::of(env, e))?;
        self.collect();
        Ok(StepView(&self.outputs))
    }

    /// Renders the current state of environment `env` like a frame of `tactus run`.
    ///
    /// # Errors
    /// Fails if no episode is running, or if its state cannot be drawn.
    pub fn render(&self, env: usize) -> Result<Pixmap> {
        self.envs[env].picture(&self.shared)
    }

    /// Returns true if environment `env` has been reset since its creation or the last interruption.
    pub fn has_started(&self, env: usize) -> bool {
        !self.envs[env].output.obs.is_empty()
    }

    /// Returns the current episode of environment `env`, or the next one before the first reset.
    pub fn key(&self, env: usize) -> EpisodeKey {
        self.envs[env].key
    }

    /// Converts the result `done` of parallel work; after an interruption, discards all episodes.
    fn finish_parallel(&mut self, done: Result<()>) -> std::result::Result<(), StepError> {
        if interrupt::requested() {
            self.envs.iter_mut().for_each(Env::discard_episode);
            return Err(StepError::interrupted());
        }
        done.map_err(|e| StepError::call(e.to_string()))
    }

    /// Returns the world of environment `env` for inspection or modification; None if no episode is running.
    pub fn environment(&mut self, env: usize) -> Option<&mut Environment> {
        self.envs[env].environment()
    }

    /// Returns the object name and the drawn parameters of the running episode of environment `env`.
    pub fn episode(&self, env: usize) -> Option<(&str, &EpisodeParameters)> {
        self.envs[env].draw().map(|draw| (self.shared.kinds[draw.object].name.as_str(), draw))
    }

    /// Gathers the results of all environments into the output arrays.
    fn collect(&mut self) {
        let out = &mut self.outputs;
        for (i, env) in self.envs.iter().enumerate() {
            let from = &env.output;
            let mut start = 0;
            for array in &mut out.arrays {
                let size = array.spec.size();
                let own = i * size..(i + 1) * size;
                let part = start..start + size;
                // An environment that was never reset has no observations.
                if let Some(obs) = from.obs.get(part.clone()) {
                    array.now[own.clone()].copy_from_slice(obs);
                }
                match from.last.get(part) {
                    Some(last) => array.last[own].copy_from_slice(last),
                    None => array.last[own].fill(0.0),
                }
                start += size;
            }
            out.reward[i] = from.reward;
            (out.terminated[i], out.truncated[i]) = (from.terminated, from.truncated);
            out.ended[i] = from.terminated || from.truncated;
            out.faults[i].clone_from(&from.fault);
            out.info[i] = from.info;
        }
    }
}
