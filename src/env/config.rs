//! Settings of a batch.

/// Settings of a [`super::BatchEnv`].
#[derive(Debug, Clone, PartialEq)]
pub struct BatchConfig {
    /// Number of environments.
    pub num_envs: usize,
    /// Global index of the first environment, so that shards of one batch on several machines number their environments
    /// consecutively.
    pub first_env: u64,
    /// Seed of all episodes until a reset sets another.
    pub seed: u64,
    /// Behaviour after the end of an episode.
    pub autoreset: Autoreset,
    /// Number of steps after which an episode is truncated; None uses that of the task.
    pub max_steps: Option<usize>,
    /// Number of threads; None uses all of the machine. Results do not depend on it, bit for bit.
    pub threads: Option<usize>,
    /// Names of the objects to draw from; None uses all objects of the scene.
    pub objects: Option<Vec<String>>,
}

impl Default for BatchConfig {
    fn default() -> Self {
        Self {
            num_envs: 1,
            first_env: 0,
            seed: 0,
            autoreset: Autoreset::default(),
            max_steps: None,
            threads: None,
            objects: None,
        }
    }
}

/// Reset modes of Gymnasium.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Autoreset {
    /// Reset in the step after the end of an episode; this step ignores its action.
    #[default]
    NextStep,
    /// Reset within the last step of an episode, whose last observation is kept as the final observation.
    SameStep,
    /// No automatic reset: the caller resets the environments whose episodes have ended.
    Disabled,
}
