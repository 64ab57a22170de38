//! Steps a batch of environments with a fixed force, and saves one of them: `cargo run --release --example environments`.

use tactus::base::error::Error;
use tactus::env::{BatchConfig, BatchEnv};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let config = BatchConfig { num_envs: 4, ..BatchConfig::default() };
    let mut envs = BatchEnv::open("scenes/tasks/hold.ron", config)?;
    let actions = envs.action_spec();
    println!("an action has {} numbers from -1 to 1; an observation has", actions.size());
    for spec in envs.observation_spec() {
        println!("  {:14} {:?}", spec.name, spec.shape);
    }
    envs.reset(Some(1), None)?;
    // Half of the way from the least to the largest force, without anything else.
    let forces = vec![0.0; envs.num_envs() * actions.size()];
    let mut earned = vec![0.0; envs.num_envs()];
    for _ in 0..10 {
        let view = envs.step(&forces)?;
        earned.iter_mut().zip(view.reward()).for_each(|(sum, reward)| *sum += reward);
        let wrench = view.obs("wrench").ok_or_else(|| Error::Start("the task observes no wrench".into()))?;
        println!("force on the left pad of the first environment: {:.2?} N", &wrench[..3]);
    }
    println!("earned: {earned:.2?}");
    let saved = envs.save(0)?;
    let reward = envs.step(&forces)?.reward()[0];
    envs.restore(0, &saved)?;
    assert_eq!(envs.step(&forces)?.reward()[0], reward, "a restored environment goes on with the same bits");
    Ok(())
}
