//! Settings of a batch.

/// Settings of a [`super::BatchEnv`].
#[derive(Debug, Clone, PartialEq)]
pub struct BatchConfig {
    /// Number of environments.
    pub num_envs: usize,
    /// Number of the first environment: shards of one batch on several machines number their environments on from it.
    pub first_env: u64,
    /// Seed of all episodes until a reset gives another.
    pub seed: u64,
    /// Behaviour after the end of an episode.
    pub autoreset: Autoreset,
    /// Number of steps after which an episode is cut off; None uses the number of the task.
    pub max_steps: Option<usize>,
    /// Number of threads; None uses as many as the machine has. The threads change no bit.
    pub threads: Option<usize>,
    /// Names of the scene's objects to draw from; None uses all.
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
    /// Reset in the step after the last one of an episode: it ignores the action and starts the next episode.
    #[default]
    NextStep,
    /// Reset in the last step of an episode: it starts the next one, and keeps the last observation as the final one.
    SameStep,
    /// No automatic reset: the caller resets the environments whose episodes have ended.
    Disabled,
}
