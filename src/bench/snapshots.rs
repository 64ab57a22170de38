//! Time and size of saved environment states, early and late in an episode.

use base::error::{Error, Result};
use base::interrupt;
use base::stats::median;
use env::{BatchConfig, BatchEnv};
use scene::NamedScene;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Number of times that a state is saved and restored; times are medians.
const REPETITIONS: usize = 5;

/// Cost of saving and restoring an environment.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct SnapshotCost {
    /// Backend of the scene, or folder of a model.
    pub backend: String,
    /// Number of steps taken before.
    pub step: usize,
    /// Size, bytes.
    pub bytes: usize,
    /// Time to save, s.
    pub save_s: f64,
    /// Time to restore, s.
    pub restore_s: f64,
}

/// Measures the cost of saving and restoring an environment of `set` after its first step and after its last but one.
///
/// # Errors
/// Fails if an environment cannot be created, stepped or restored.
pub fn measure_snapshots(set: &[NamedScene], backend: &str, steps: usize) -> Result<Vec<SnapshotCost>> {
    let mut env = BatchEnv::new(set, BatchConfig { num_envs: 1, threads: Some(1), ..BatchConfig::default() })?;
    let failed = |e: env::StepError| Error::Solver(e.to_string());
    env.reset(None, None).map_err(failed)?;
    let still = vec![0.0; env.action_spec().size()];
    let mut costs = Vec::new();
    for step in 1..steps {
        env.step(&still).map_err(failed)?;
        interrupt::check()?;
        if step != 1 && step != steps - 1 {
            continue;
        }
        let (mut bytes, mut times) = (0, Vec::new());
        for _ in 0..REPETITIONS {
            let clock = Instant::now();
            let saved = env.save(0)?;
            let saving = clock.elapsed().as_secs_f64();
            bytes = saved.to_bytes().map_err(Error::Solver)?.len();
            let clock = Instant::now();
            env.restore(0, &saved).map_err(failed)?;
            times.push((saving, clock.elapsed().as_secs_f64()));
        }
        let [save_s, restore_s] = [median(times.iter().map(|t| t.0)), median(times.iter().map(|t| t.1))];
        costs.push(SnapshotCost { backend: backend.into(), step, bytes, save_s, restore_s });
    }
    Ok(costs)
}
