//! A small task for every backend.
#![allow(dead_code, reason = "every test binary uses its own part")]

use std::sync::OnceLock;
use tactus::env::{Autoreset, BatchConfig, BatchEnv, StepView};
use tactus::random::Random;
use tactus::scene::{Gnn, NamedScene, Stepper, load_set};

/// The objects of the tiny data set, held with what its network was trained on.
const TASK: &str = r#"Scene(
    objects: [
        (name: "ball", object: (shape: Sphere(radius: 0.02)), grasps: Antipodal(count: 3, seed: 1)),
        (name: "box", object: (shape: Cuboid(size: (0.03, 0.04, 0.05), edge_radius: 0.004)), grasps: List([
            (position: (0, 0, -0.1)), (position: (0.0, 0, -0.1), rotation: RpyDeg((0, 0, 90)))])),
    ],
    gripper: (pads: GelSightMini(spacing: 8e-3)),
    loading: Squeeze(force: 2.0, frames: 2),
    task: (
        gravity: (0, -9.81, 0),
        force: (1.0, 2.0), start: 1.5, steps: 5, lift: 2,
        pushes: (force: (0.02, 0.1), every: 3, lasts: 2),
        observe: [TaxelForce(rows: 5, cols: 4), TaxelDisplacement(rows: 5, cols: 4), Wrench, Travel, ObjectPose, Force],
        reward: [Hold(), Slip(), Economy(), Stress(limit: 1e4)],
        randomise: (density: (300, 600), shift: 1e-3, turn_deg: 2),
    ),
)"#;

/// Episodes have this many steps.
pub const STEPS: usize = 5;
pub const NAMES: [&str; 6] = ["taxel_force", "taxel_displacement", "wrench", "travel", "object_pose", "force"];

/// The task with `change` made in its text.
pub fn changed(change: impl Fn(&str) -> String) -> Vec<NamedScene> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("task.ron");
    std::fs::write(&path, change(TASK)).unwrap();
    load_set(&path).unwrap_or_else(|e| panic!("{e}")).scenes
}

pub fn fem() -> Vec<NamedScene> {
    static SET: OnceLock<Vec<NamedScene>> = OnceLock::new();
    SET.get_or_init(|| changed(str::to_string)).clone()
}

pub fn condensed() -> Vec<NamedScene> {
    changed(|task| task.replacen("loading:", "stepper: Fem(solver: Condensed(error: 0.01)), loading:", 1))
}

pub fn gnn(mut set: Vec<NamedScene>, model: &std::path::Path) -> Vec<NamedScene> {
    set.iter_mut().for_each(|s| s.scene.stepper = Stepper::Gnn(Gnn { model: model.to_path_buf() }));
    set
}

pub fn config(num_envs: usize) -> BatchConfig {
    BatchConfig { num_envs, seed: 7, threads: Some(2), ..BatchConfig::default() }
}

pub fn batch(set: &[NamedScene], config: BatchConfig) -> BatchEnv {
    BatchEnv::new(set, config).unwrap_or_else(|e| panic!("{e}"))
}

/// Actions of all environments, by step and environment alone.
pub fn actions(first_env: u64, num_envs: usize, step: usize) -> Vec<f32> {
    let one = |i: usize| Random::new(1000 * step as u64 + first_env + i as u64).unit() as f32 * 2.0 - 1.0;
    (0..num_envs).map(one).collect()
}

/// All bits that environment `env` gave.
pub fn bits(view: StepView, env: usize) -> Vec<u32> {
    let n = view.reward().len();
    let row = |all: &[f32]| {
        all[env * all.len() / n..(env + 1) * all.len() / n].iter().map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    let arrays = NAMES.iter().flat_map(|name| row(view.obs(name).unwrap()));
    let flags = [view.terminated()[env], view.truncated()[env], view.fault(env).is_some()].map(u32::from);
    arrays.chain([view.reward()[env].to_bits()]).chain(flags).collect()
}

/// What every environment of a batch gives in `steps` steps after a reset: [step][environment].
pub fn play(env: &mut BatchEnv, steps: usize) -> Vec<Vec<Vec<u32>>> {
    let (n, first) = (env.num_envs(), env.config().first_env);
    let start = env.reset(None, None).unwrap();
    let mut all = vec![(0..n).map(|i| bits(start, i)).collect::<Vec<_>>()];
    for step in 0..steps {
        let view = env.step(&actions(first, n, step)).unwrap();
        all.push((0..n).map(|i| bits(view, i)).collect());
    }
    all
}

pub fn with(autoreset: Autoreset, num_envs: usize) -> BatchConfig {
    BatchConfig { autoreset, ..config(num_envs) }
}
