//! Contract of a batch of environments, tested bit for bit for every backend.

use crate::env_made::*;
use std::sync::{LazyLock, OnceLock};
use tactus::env::{Autoreset, BatchConfig, BatchEnv, Snapshot};
use tactus::scene::NamedScene;
use tactus::world::schedule::{NextPhase, Phase};

/// The task on one backend.
struct Backend {
    set: Vec<NamedScene>,
    played: OnceLock<Vec<Vec<Vec<u32>>>>,
}

impl Backend {
    fn new(set: Vec<NamedScene>) -> Self {
        Self { set, played: OnceLock::new() }
    }

    /// Outputs of four environments at a reset and in the steps of an episode and two more, shared by tests:
    /// [step][environment].
    fn played(&self) -> &[Vec<Vec<u32>>] {
        self.played.get_or_init(|| play(&mut batch(&self.set, config(4)), STEPS + 2))
    }
}

/// Defines each test for each backend.
macro_rules! for_each {
    ($($name:ident)*) => {
        for_each!(in fem_backend, fem(); $($name)*);
        for_each!(in condensed_backend, condensed(); $($name)*);
        for_each!(in gnn_backend, gnn(fem(), &crate::gnn_made::made().model); $($name)*);
    };
    (in $backend:ident, $set:expr; $($name:ident)*) => {
        mod $backend {
            use super::*;

            static BACKEND: LazyLock<Backend> = LazyLock::new(|| Backend::new($set));

            $(#[test]
            fn $name() {
                super::$name(&BACKEND);
            })*
        }
    };
}

for_each! {
    threads_and_batch_size_change_no_bit
    a_masked_reset_leaves_the_others_alone
    truncation_keeps_the_final_observation
    episodes_differ_and_start_like_fresh_ones
    a_restored_environment_goes_on_exactly
    a_snapshot_does_not_grow_with_the_episode
    a_snapshot_that_does_not_fit_is_refused
    seeds_of_their_own_start_the_episodes_of_single_environments
    a_bad_action_names_its_environment_and_changes_nothing
    a_fault_stays_in_its_environment
}

fn threads_and_batch_size_change_no_bit(on: &Backend) {
    let set = &on.set[..];
    let all = on.played();
    let serial = BatchConfig { threads: Some(1), ..config(4) };
    assert_eq!(all, play(&mut batch(set, serial), STEPS + 2), "on one thread");
    let part = BatchConfig { first_env: 2, ..config(2) };
    let part = play(&mut batch(set, part), STEPS + 2);
    for (all, part) in all.iter().zip(&part) {
        assert_eq!(all[2..4], part[..], "two of the four environments alone");
    }
}

fn a_masked_reset_leaves_the_others_alone(on: &Backend) {
    let set = &on.set[..];
    let mut env = batch(set, config(3));
    env.reset(None, None).unwrap();
    env.step(&actions(0, 3, 0)).unwrap();
    env.reset(None, Some(&[false, true, false])).unwrap();
    let view = env.step(&actions(0, 3, 1)).unwrap();
    let (plain, masked) = (&on.played()[2], [0, 1, 2].map(|i| bits(view, i)));
    assert_eq!((&plain[0], &plain[2]), (&masked[0], &masked[2]));
    assert_ne!(plain[1], masked[1], "the one in the middle is in another episode");
    assert!(batch(set, config(3)).reset(None, Some(&[true])).unwrap_err().to_string().contains("1 entry for 3"));
}

fn truncation_keeps_the_final_observation(on: &Backend) {
    let set = &on.set[..];
    let (mut same, mut next) = (batch(set, with(Autoreset::SameStep, 1)), batch(set, with(Autoreset::NextStep, 1)));
    same.reset(None, None).unwrap();
    next.reset(None, None).unwrap();
    for step in 0..STEPS {
        let action = [0.5];
        let (a, b) = (same.step(&action).unwrap(), next.step(&action).unwrap());
        assert_eq!((a.reward(), a.terminated(), a.truncated()), (b.reward(), b.terminated(), b.truncated()));
        assert_eq!(a.truncated()[0], step + 1 == STEPS, "no object is lost");
        for name in NAMES {
            let seen = if a.ended()[0] { a.final_obs(name) } else { a.obs(name) };
            assert_eq!(seen, b.obs(name), "step {step}: {name}");
        }
    }
    let next_episode = save_of_next(set);
    let fresh: Vec<_> =
        NAMES.iter().map(|name| same.restore(0, &next_episode).unwrap().obs(name).unwrap().to_vec()).collect();
    let after = next.step(&[-1.0]).unwrap();
    assert_eq!((after.reward()[0], after.truncated()[0]), (0.0, false), "the action of this step is not taken");
    for (name, fresh) in NAMES.iter().zip(fresh) {
        assert_eq!(after.obs(name).unwrap(), fresh, "the next episode starts: {name}");
    }
}

/// The start of the second episode of the first environment.
fn save_of_next(set: &[NamedScene]) -> tactus::env::Snapshot {
    let mut env = batch(set, config(1));
    env.reset(None, None).unwrap();
    env.reset(None, None).unwrap();
    env.save(0).unwrap()
}

fn episodes_differ_and_start_like_fresh_ones(on: &Backend) {
    let set = &on.set[..];
    let mut env = batch(set, config(2));
    let first = env.reset(None, None).unwrap();
    let first = [bits(first, 0), bits(first, 1)];
    assert_ne!(first[0], first[1], "environments differ");
    env.step(&[0.0, 0.0]).unwrap();
    let second = env.reset(None, None).unwrap();
    assert_ne!(first[0], bits(second, 0), "episodes differ");
    let again = env.reset(Some(7), None).unwrap();
    assert_eq!(first, [bits(again, 0), bits(again, 1)], "the same seed starts the same episodes");
    let other = env.reset(Some(8), None).unwrap();
    assert_ne!(first[0], bits(other, 0), "another seed, another episode");
}

fn a_restored_environment_goes_on_exactly(on: &Backend) {
    let set = &on.set[..];
    let mut env = batch(set, config(2));
    env.reset(None, None).unwrap();
    for step in 0..2 {
        env.step(&actions(0, 2, step)).unwrap();
    }
    let saved = Snapshot::from_bytes(&env.save(1).unwrap().to_bytes().unwrap()).unwrap();
    let rest = |env: &mut BatchEnv, at: usize| {
        (2..STEPS).map(|s| bits(env.step(&actions(0, 2, s)).unwrap(), at)).collect::<Vec<_>>()
    };
    let truth = rest(&mut env, 1);
    env.restore(1, &saved).unwrap();
    assert_eq!(truth, rest(&mut env, 1), "in the same batch");
    let mut other = batch(set, BatchConfig { seed: 99, ..config(2) });
    other.reset(None, None).unwrap();
    other.restore(1, &saved).unwrap();
    assert_eq!(truth, rest(&mut other, 1), "in another batch");
}

/// A snapshot holds a state and not a list of actions: its size after each step varies by at most 10 %, with the number
/// of contact edges (a few hundred bytes each).
fn a_snapshot_does_not_grow_with_the_episode(on: &Backend) {
    let set = &on.set[..];
    let mut env = batch(set, config(1));
    env.reset(None, None).unwrap();
    let mut sizes = Vec::new();
    for _ in 0..STEPS - 1 {
        env.step(&[0.0]).unwrap();
        sizes.push(env.save(0).unwrap().to_bytes().unwrap().len() as f64);
    }
    let [least, most] = [f64::min, f64::max].map(|pick| sizes.iter().copied().reduce(pick).unwrap());
    assert!(most <= 1.1 * least, "from {least} to {most} bytes");
}

fn a_snapshot_that_does_not_fit_is_refused(on: &Backend) {
    let set = &on.set[..];
    let mut env = batch(set, config(2));
    env.reset(None, None).unwrap();
    let before = bits(env.step(&actions(0, 2, 0)).unwrap(), 1);
    let good = env.save(1).unwrap();
    let bytes = good.to_bytes().unwrap();
    for cut in [0, 1, bytes.len() / 2, bytes.len() - 1] {
        let error = Snapshot::from_bytes(&bytes[..cut]).unwrap_err();
        assert!(error.starts_with("the snapshot cannot be read"), "{error}");
    }
    assert_eq!(Snapshot::from_bytes(&bytes).unwrap(), good);
    let changed = |change: &dyn Fn(&mut Snapshot)| {
        let mut bad = good.clone();
        change(&mut bad);
        bad
    };
    let other = {
        let slower = set.iter().cloned().map(|mut named| {
            named.scene.task.as_mut().unwrap().lift = tactus::scene::leaf::Count::new(3).unwrap();
            named
        });
        let mut env = batch(&slower.collect::<Vec<_>>(), config(2));
        env.reset(None, None).unwrap();
        env.save(1).unwrap()
    };
    let cases = [
        (changed(&|s| s.state[100] ^= 1), "environment 1: the snapshot was changed or damaged"),
        (changed(&|s| s.state.truncate(100)), "environment 1: the snapshot was changed or damaged"),
        (changed(&|s| s.key.episode += 1), "environment 1: the snapshot was changed or damaged"),
        (changed(&|s| s.format = 7), "environment 1: the snapshot has format 7"),
        (other, "environment 1: the snapshot belongs to another scene"),
    ];
    for (bad, said) in cases {
        let error = env.restore(1, &bad).unwrap_err();
        assert!(error.to_string().starts_with(said), "{error}");
    }
    assert!(env.restore(2, &good).unwrap_err().to_string().contains("environment 2 of 2"));
    assert_eq!(before, bits(env.view(), 1), "nothing has changed");
    assert_eq!(before, bits(env.restore(1, &good).unwrap(), 1));
}

fn seeds_of_their_own_start_the_episodes_of_single_environments(on: &Backend) {
    let set = &on.set[..];
    let mut env = batch(set, config(3));
    env.reset(None, None).unwrap();
    let view = env.reset_each(&[Some(3), None, Some(4)], None).unwrap();
    let rows = [0, 1, 2].map(|i| bits(view, i));
    assert_eq!([0, 1, 2].map(|i| (env.key(i).seed, env.key(i).episode)), [(3, 0), (7, 1), (4, 0)]);
    let mut alone = batch(set, config(1));
    assert_eq!(rows[0], bits(alone.reset(Some(3), None).unwrap(), 0));
    assert_eq!(rows[2], bits(alone.reset(Some(4), None).unwrap(), 0));
    assert!(env.reset_each(&[None], None).unwrap_err().to_string().contains("1 seed for 3 environments"));
    // A common seed gives each environment the random stream of its index again.
    let all = env.reset(Some(3), None).unwrap();
    let all = [0, 1, 2].map(|i| bits(all, i));
    let mut fresh = batch(set, config(3));
    let fresh = fresh.reset(Some(3), None).unwrap();
    assert_eq!(all, [0, 1, 2].map(|i| bits(fresh, i)));
}

fn a_bad_action_names_its_environment_and_changes_nothing(on: &Backend) {
    let set = &on.set[..];
    let mut env = batch(set, config(3));
    let early = env.step(&[0.0; 3]).unwrap_err();
    assert_eq!(early.env, Some(0), "{early}");
    env.reset(None, None).unwrap();
    let error = env.step(&[0.0, f32::NAN, 0.0]).unwrap_err();
    assert_eq!(error.env, Some(1));
    assert_eq!(error.to_string(), "environment 1: its action contains NaN; allowed: -1 to 1");
    assert!(env.step(&[0.0; 2]).unwrap_err().to_string().contains("2 numbers for 3 environments with 1 each"));
    let view = env.step(&actions(0, 3, 0)).unwrap();
    let after = [0, 1, 2].map(|i| bits(view, i));
    assert_eq!(on.played()[1][..3], after, "as if nobody had asked");
}

fn a_fault_stays_in_its_environment(on: &Backend) {
    let set = &on.set[..];
    let mut env = batch(set, config(3));
    env.reset(None, None).unwrap();
    let world = env.environment(1).unwrap().world_mut();
    world.resource_mut::<NextPhase>().request(Phase::Fault { reason: "poisoned".into() });
    let poisoned: Vec<_> = (0..3)
        .map(|step| {
            let view = env.step(&actions(0, 3, step)).unwrap();
            assert!(NAMES.iter().all(|name| view.obs(name).unwrap().iter().all(|v| v.is_finite())));
            ([0, 1, 2].map(|i| bits(view, i)), view.fault(1).map(str::to_string), view.terminated()[1])
        })
        .collect();
    for (clean, poisoned) in on.played()[1..].iter().zip(&poisoned) {
        assert_eq!((&clean[0], &clean[2]), (&poisoned.0[0], &poisoned.0[2]), "the neighbours");
        // The last of the flags is that of a fault.
        assert!(clean[1].iter().all(|v| f32::from_bits(*v).is_finite()) && clean[1].last() == Some(&0));
    }
    let fault: Vec<_> = poisoned.iter().find(|step| step.1.is_some()).into_iter().collect();
    assert_eq!((fault[0].1.as_deref(), fault[0].2), (Some("poisoned"), true), "flagged, and the episode ends");
    assert_eq!((&poisoned[2].1, poisoned[2].2), (&None, false), "and the next one runs");
}
