//! Environments of a network that falls back to finite elements: each episode runs on the backend chosen for its grasp,
//! in a reused world.

use crate::env_made::{actions, batch, bits, config, fem};
use crate::gnn_made::made;
use tactus::backend::network::NetworkStepper;
use tactus::env::{Autoreset, BatchConfig, BatchEnv, Snapshot};
use tactus::scene::leaf::Positive;
use tactus::scene::{Gnn, NamedScene, StepperChoice};
use tactus::world::Environment;

/// The small task on the network, with a fallback to finite elements above a predicted error of `at_most`.
fn guarded(at_most: Option<f64>) -> Vec<NamedScene> {
    let error_at_most = at_most.map(|most| Positive::new(most).unwrap());
    let stepper = StepperChoice::Gnn(Gnn { error_at_most, ..Gnn::new(&made().sure) });
    let mut set = fem();
    set.iter_mut().for_each(|named| named.scene.stepper = stepper.clone());
    set
}

/// Median predicted error of the first eight episodes.
fn half() -> f64 {
    let network = NetworkStepper::open(&made().sure).unwrap();
    let mut env = batch(&guarded(None), config(1));
    let mut errors: Vec<f64> = (0..8)
        .map(|_| {
            env.reset(None, None).unwrap();
            let Some(running) = env.environment(0) else { panic!("an episode without a feasible start") };
            let mut alone = Environment::new(&running.model().clone(), &network, running.pose()).unwrap();
            network.predict_all_loads(alone.world_mut()).unwrap()
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    0.5 * (errors[3] + errors[4])
}

fn handed_over(env: &mut BatchEnv) -> bool {
    env.environment(0).unwrap().fallback_reason().is_some()
}

#[test]
fn worlds_are_used_again_whichever_backend_was_chosen() {
    let set = guarded(Some(half()));
    let one = BatchConfig { autoreset: Autoreset::Disabled, ..config(1) };
    // 50 resets in each order; each tenth episode takes a step, too.
    let play = |order: &mut dyn Iterator<Item = u64>| {
        let mut env = batch(&set, one.clone());
        let mut all: Vec<_> = order
            .map(|seed| {
                let start = bits(env.reset(Some(seed), None).unwrap(), 0);
                let chosen = handed_over(&mut env);
                let step = (seed % 10 == 0).then(|| bits(env.step(&actions(0, 1, 0)).unwrap(), 0));
                (seed, chosen, start, step)
            })
            .collect();
        all.sort();
        all
    };
    let all = play(&mut (0..50));
    assert_eq!(all, play(&mut (0..50).rev()), "what a world did before changes no bit");
    let elements = all.iter().filter(|(_, chosen, ..)| *chosen).count();
    assert!((5..=45).contains(&elements), "{elements} of 50 episodes on finite elements");
}

#[test]
fn a_restored_episode_goes_on_with_the_backend_of_its_grasp() {
    let set = guarded(Some(half()));
    let (mut env, mut other) = (batch(&set, config(1)), batch(&set, BatchConfig { seed: 99, ..config(1) }));
    other.reset(None, None).unwrap();
    let mut seen = [false; 2];
    for seed in 0..20 {
        env.reset(Some(seed), None).unwrap();
        let chosen = handed_over(&mut env);
        if std::mem::replace(&mut seen[usize::from(chosen)], true) {
            continue;
        }
        env.step(&actions(0, 1, 0)).unwrap();
        let saved = Snapshot::from_bytes(&env.save(0).unwrap().to_bytes().unwrap()).unwrap();
        let rest =
            |env: &mut BatchEnv| (1..3).map(|s| bits(env.step(&actions(0, 1, s)).unwrap(), 0)).collect::<Vec<_>>();
        let truth = rest(&mut env);
        for again in [&mut env, &mut other] {
            again.restore(0, &saved).unwrap();
            assert_eq!(handed_over(again), chosen);
            assert_eq!(truth, rest(again), "finite elements: {chosen}");
        }
    }
    assert_eq!(seen, [true; 2], "both backends were chosen");
}
