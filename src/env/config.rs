//! How a batch is set up.

/// Settings of a [`super::BatchEnv`].
#[derive(Debug, Clone, PartialEq)]
pub struct BatchConfig {
    /// Number of environments.
    pub num_envs: usize,
    /// Number of the first environment: shards of one batch on several machines count on.
    pub first_env: u64,
    /// Seed of all episodes until a reset gives another.
    pub seed: u64,
    /// What happens when an episode has ended.
    pub autoreset: Autoreset,
    /// Steps after which an episode is cut off; None is what the task says.
    pub max_steps: Option<usize>,
    /// Threads; None is as many as the machine has. They change no bit.
    pub threads: Option<usize>,
    /// Names of the scene's objects to draw from; None is all.
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

/// Gymnasium's modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Autoreset {
    /// The step after the last one of an episode takes no notice of the action and starts the next episode.
    #[default]
    NextStep,
    /// The last step of an episode starts the next one; the last observation is the final one.
    SameStep,
    /// Nothing: the caller resets what has ended.
    Disabled,
}
