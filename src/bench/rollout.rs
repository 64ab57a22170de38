//! Throughput of batches of reinforcement learning environments, in steps per second, against the numbers of
//! environments and threads; memory per environment; cost of saving and restoring an environment.

use super::clock::{peak_memory, reset_peak_memory};
use super::snapshots::{SnapshotCost, measure_snapshots};
use backend::choose;
use base::error::{Error, Result};
use base::interrupt;
use base::random::Random;
use base::stats::median;
use env::{BatchConfig, BatchEnv};
use plotters::prelude::*;
use record::render::canvas::{
    AXIS_COLOR, Area, DrawChart, DrawResult, SERIES_COLORS, axes, range, save_picture, text_style,
};
use scene::{Gnn, NamedScene, StepperChoice};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Minimum run time of a batch, s; it runs for at least one episode.
const MIN_BATCH_TIME: f64 = 2.0;
/// Maximum time of an episode, s; a batch that is expected to exceed it is skipped.
const MAX_EPISODE_TIME: f64 = 60.0;

/// Throughput of a batch of environments on one backend, for one number of environments and threads.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Rate {
    /// Backend of the scene (`fem`, `gnn`), or folder or name of a trained model.
    pub backend: String,
    /// Number of environments in the batch.
    pub envs: usize,
    /// Number of threads that advance the batch.
    pub threads: usize,
    /// Environment steps per second of wall time, summed over the batch, under a random policy, resets included: median
    /// over the repetitions.
    pub steps_per_s: f64,
    /// Wall time of the longest step of the batch over that of its median step: largest over the repetitions.
    #[serde(default)]
    pub worst_over_median: f64,
    /// Largest resident memory of the process during the batch, bytes: largest over the repetitions; None (`null` in
    /// JSON) if the system does not provide it.
    pub peak_memory_bytes: Option<u64>,
}

/// Results of a throughput measurement over all backends and numbers of environments and threads.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Rollouts {
    /// Throughput of each batch, ordered by backend, number of threads and number of environments.
    pub rates: Vec<Rate>,
    /// Memory that each additional environment adds to the process, as pairs of backend and bytes; without the backends
    /// for which it is not known.
    pub memory_per_env_bytes: Vec<(String, f64)>,
    /// Costs of saving and restoring an environment, ordered by backend.
    #[serde(default)]
    pub snapshots: Vec<SnapshotCost>,
    /// Names of the skipped batches: an episode was expected to take more than 60 s.
    pub left_out: Vec<String>,
    /// Number of repetitions of each batch.
    pub repeats: usize,
}

/// Measures the throughput of the reinforcement learning task of `set` (the scenes of one file, one per object) on the
/// backend of the scene and on each of `models` (folders or names of trained models), for every number of environments
/// in `envs` and of threads in `threads`. Each batch runs `repeats` times under a random policy. `progress` receives
/// the name of each batch before it runs.
///
/// # Errors
/// Fails if the scene has no task, a model does not support it, a step fails, or the process is interrupted.
pub fn rollouts(
    set: &[NamedScene],
    models: &[PathBuf],
    envs: &[usize],
    threads: &[usize],
    repeats: usize,
    mut progress: impl FnMut(&str),
) -> Result<Rollouts> {
    let task = set.first().and_then(|s| s.scene.task.as_ref());
    let task = task.ok_or_else(|| Error::Argument("--envs needs a scene with a task".into()))?;
    let steps = task.steps.get();
    let mut envs = envs.to_vec();
    envs.sort_unstable();
    envs.dedup();
    let (mut rates, mut saved, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    for model in std::iter::once(None).chain(models.iter().map(Some)) {
        let mut set = set.to_vec();
        if let Some(model) = model {
            set.iter_mut().for_each(|s| s.scene.stepper = StepperChoice::Gnn(Gnn::new(model.clone())));
        }
        let own = || choose(&set[0].scene).map(|stepper| stepper.name().to_string());
        let backend = model.map_or_else(own, |m| Ok(m.display().to_string()))?;
        progress(&format!("{backend}, saved environments"));
        saved.extend(measure_snapshots(&set, &backend, steps)?);
        for &threads in threads {
            let mut rate = f64::INFINITY;
            for &n in &envs {
                let name = format!("{backend}, environments: {n}, threads: {threads}");
                if (n * steps) as f64 / rate > MAX_EPISODE_TIME {
                    left_out.push(name);
                    continue;
                }
                progress(&name);
                let turns = (0..repeats).map(|_| run_batch(&set, n, threads, steps)).collect::<Result<Vec<_>>>()?;
                rate = median(turns.iter().map(|t| t.steps_per_s));
                rates.push(Rate {
                    backend: backend.clone(),
                    envs: n,
                    threads,
                    steps_per_s: rate,
                    worst_over_median: turns.iter().map(|t| t.worst_over_median).fold(0.0, f64::max),
                    peak_memory_bytes: turns.iter().filter_map(|t| t.peak_memory_bytes).max(),
                });
            }
        }
    }
    Ok(Rollouts { memory_per_env_bytes: memory_per_env(&rates), rates, snapshots: saved, left_out, repeats })
}

/// Results of one repetition of a batch.
struct RepetitionResult {
    steps_per_s: f64,
    worst_over_median: f64,
    peak_memory_bytes: Option<u64>,
}

/// Runs one batch under a random policy.
fn run_batch(set: &[NamedScene], num_envs: usize, threads: usize, steps: usize) -> Result<RepetitionResult> {
    let known = reset_peak_memory();
    let mut env = BatchEnv::new(set, BatchConfig { num_envs, threads: Some(threads), ..BatchConfig::default() })?;
    let failed = |e: env::StepError| Error::Solver(e.to_string());
    env.reset(None, None).map_err(failed)?;
    let mut random = Random::new(1);
    let numbers = num_envs * env.action_spec().size();
    let (clock, mut times) = (Instant::now(), Vec::new());
    while times.len() < steps || clock.elapsed().as_secs_f64() < MIN_BATCH_TIME {
        let actions: Vec<f32> = (0..numbers).map(|_| 2.0 * random.uniform() as f32 - 1.0).collect();
        let step = Instant::now();
        env.step(&actions).map_err(failed)?;
        interrupt::check()?;
        times.push(step.elapsed().as_secs_f64());
    }
    let worst = times.iter().copied().fold(0.0, f64::max);
    Ok(RepetitionResult {
        steps_per_s: (times.len() * num_envs) as f64 / clock.elapsed().as_secs_f64(),
        worst_over_median: worst / median(times.iter().copied()),
        peak_memory_bytes: peak_memory().filter(|_| known),
    })
}

/// Returns the memory per environment of each backend: the slope from the batch with the least memory to the largest
/// batch. The batch with the least memory need not be the smallest, because a small batch may reuse memory of an
/// earlier large one.
fn memory_per_env(rates: &[Rate]) -> Vec<(String, f64)> {
    let mut all: Vec<(String, f64)> = Vec::new();
    for rate in rates {
        if all.iter().any(|(backend, _)| *backend == rate.backend) {
            continue;
        }
        let own = || rates.iter().filter(|r| r.backend == rate.backend && r.threads == rate.threads);
        let known = || own().filter_map(|r| r.peak_memory_bytes.map(|b| (r.envs as f64, b as f64)));
        let least = known().min_by(|a, b| a.1.total_cmp(&b.1));
        let most = known().max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some(((n, least), (m, most))) = least.zip(most).filter(|(a, b)| a.0 < b.0) {
            all.push((rate.backend.clone(), (most - least) / (m - n)));
        }
    }
    all
}

/// Writes the chart of steps per second against the number of environments, one line per backend and number of threads,
/// as `envs.png` and `envs.svg` into the folder `dir`.
///
/// # Errors
/// Fails if a file cannot be written.
pub fn save_chart(report: &Rollouts, dir: &Path) -> Result<()> {
    save_picture(report, dir, "envs")
}

/// Returns the report as text: a row per batch, then memory per environment, costs of saved environments and skipped
/// batches.
pub fn text(report: &Rollouts) -> String {
    let mut text = format!(
        "random policy, repetitions: {}\n\nsteps/s  environments  threads  worst/median step  memory MB  backend\n",
        report.repeats
    );
    for r in &report.rates {
        let memory = r.peak_memory_bytes.map_or("-".into(), |b| format!("{:.0}", b as f64 / 1e6));
        let Rate { steps_per_s, envs, threads, worst_over_median, backend, .. } = r;
        text += &format!(
            "{steps_per_s:>7.0}  {envs:>12}  {threads:>7}  {worst_over_median:>17.1}  {memory:>9}  {backend}\n"
        );
    }
    text.push('\n');
    for (backend, bytes) in &report.memory_per_env_bytes {
        text += &format!("memory per environment {:.2} MB: {backend}\n", bytes / 1e6);
    }
    for s in &report.snapshots {
        text += &format!(
            "saved after {} steps: {:.2} MB, {:.2} ms to save, {:.2} ms to restore: {}\n",
            s.step,
            s.bytes as f64 / 1e6,
            s.save_s * 1e3,
            s.restore_s * 1e3,
            s.backend
        );
    }
    for name in &report.left_out {
        text += &format!("omitted, an episode would take more than {MAX_EPISODE_TIME:.0} s: {name}\n");
    }
    text
}

impl Rollouts {
    /// Returns the rates grouped by backend and number of threads.
    fn lines(&self) -> Vec<Vec<&Rate>> {
        let mut lines: Vec<Vec<&Rate>> = Vec::new();
        for rate in &self.rates {
            let same = |r: &Rate| r.backend == rate.backend && r.threads == rate.threads;
            match lines.iter_mut().find(|line| same(line[0])) {
                Some(line) => line.push(rate),
                None => lines.push(vec![rate]),
            }
        }
        lines
    }

    fn color(&self, line: &[&Rate]) -> RGBColor {
        SERIES_COLORS[usize::from(line[0].backend != self.rates[0].backend)]
    }
}

impl DrawChart for Rollouts {
    fn plot<B: DrawingBackend>(&self, area: &Area<B>) -> DrawResult<B> {
        let envs = range(self.rates.iter().map(|r| r.envs as f64));
        let rates = range(self.rates.iter().map(|r| r.steps_per_s));
        let name = "steps of single environments per second, random policy";
        let mut chart = axes(area, (envs, "environments".into()), (rates, name.into()))?;
        for line in self.lines() {
            let color = self.color(&line);
            let points: Vec<(f64, f64)> = line.iter().map(|r| (r.envs as f64, r.steps_per_s)).collect();
            chart.draw_series(LineSeries::new(points.iter().copied(), color.stroke_width(2)))?;
            chart.draw_series(points.iter().map(|at| Circle::new(*at, 4, color.filled())))?;
            if let Some(last) = points.last() {
                let label = EmptyElement::at(*last)
                    + Text::new(format!("threads: {}", line[0].threads), (-60, -22), text_style(15, &color));
                chart.draw_series([label])?;
            }
        }
        Ok(())
    }

    fn list(&self) -> Vec<(String, RGBColor)> {
        let mut lines = Vec::new();
        for line in self.lines() {
            if let Some(best) = line.iter().max_by(|a, b| a.steps_per_s.total_cmp(&b.steps_per_s)) {
                lines.push((best.backend.clone(), self.color(&line)));
                let rate = format!(
                    "    threads: {}, at best {:.0} steps/s ({} environments)",
                    best.threads, best.steps_per_s, best.envs
                );
                lines.push((rate, self.color(&line)));
            }
        }
        lines.push((String::new(), AXIS_COLOR));
        let memory = |(backend, bytes): &(String, f64)| {
            (format!("{:.2} MB per environment: {backend}", bytes / 1e6), AXIS_COLOR)
        };
        lines.extend(self.memory_per_env_bytes.iter().map(memory));
        lines
    }
}
