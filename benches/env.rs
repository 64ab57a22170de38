//! Time per step of a batch of environments, resets included.
//!
//! `TACTUS_TASK_MODEL` names the folder of a trained network; without it only finite elements are timed.

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use mimalloc::MiMalloc;
use std::path::PathBuf;
use tactus::base::random::Random;
use tactus::env::{BatchConfig, BatchEnv};
use tactus::scene::{Gnn, StepperChoice, load_set};

/// Allocator of the program and the Python package.
#[global_allocator]
static ALLOCATOR: MiMalloc = MiMalloc;

const SCENE: &str = "scenes/tasks/hold.ron";

fn batch(num_envs: usize, model: Option<PathBuf>) -> Option<BatchEnv> {
    let mut set = load_set(SCENE).ok()?.scenes;
    if let Some(model) = model {
        set.iter_mut().for_each(|s| s.scene.stepper = StepperChoice::Gnn(Gnn::new(model.clone())));
    }
    let mut env = BatchEnv::new(&set, BatchConfig { num_envs, ..BatchConfig::default() }).ok()?;
    env.reset(None, None).ok()?;
    Some(env)
}

fn throughput(c: &mut Criterion) {
    let network = std::env::var_os("TACTUS_TASK_MODEL").map(PathBuf::from);
    let cases = [("finite elements", 64, Some(None)), ("network", 64, network.map(Some))];
    for (name, num_envs, model) in cases {
        let Some(mut env) = model.and_then(|model| batch(num_envs, model)) else {
            println!("{name}: skipped, no model");
            continue;
        };
        let mut group = c.benchmark_group("hold");
        group.throughput(Throughput::Elements(num_envs as u64)).sample_size(20);
        // A policy that drops the object early is reset often, and a new grasp costs most.
        for (policy, spread) in [("random", 1.0), ("steady", 0.0)] {
            let mut random = Random::new(1);
            group.bench_function(format!("{num_envs} environments, {name}, {policy} policy"), |b| {
                let mut draw =
                    || (0..num_envs).map(|_| spread * (2.0 * random.uniform() as f32 - 1.0)).collect::<Vec<_>>();
                b.iter_batched(&mut draw, |actions| env.step(&actions).is_ok(), BatchSize::SmallInput)
            });
        }
        group.finish();
    }
}

criterion_group!(benches, throughput);
criterion_main!(benches);
