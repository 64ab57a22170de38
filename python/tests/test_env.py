"""Environments conform to Gymnasium, with finite elements (tests of environments with the network are in Rust)."""

import copy
import pickle
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import tactus
from tactus.models import lasting

HOLD = Path(__file__).parents[2] / "scenes" / "tasks" / "hold.ron"
REGRASP = HOLD.with_name("regrasp.ron")


def vector(**settings):
    return tactus.VectorEnv(HOLD, 2, objects=["sphere"], max_steps=3, threads=2, **settings)


def test_gymnasium_checks_one_environment():
    check_env(tactus.Env(HOLD, objects=["sphere"], max_steps=3), skip_render_check=True)


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_spaces_and_types_are_what_they_say(mode):
    env = vector(autoreset_mode=mode)
    assert env.metadata["autoreset_mode"] == mode
    obs, _ = env.reset(seed=1)
    assert env.observation_space.contains(obs)
    obs, reward, terminated, truncated, infos = env.step(env.action_space.sample())
    assert env.observation_space.contains(obs)
    assert all(a.dtype == np.float32 for a in obs.values()) and reward.dtype == np.float32
    assert terminated.dtype == truncated.dtype == np.bool_
    assert infos["fault"].tolist() == [None, None]
    assert set(env.units) == set(obs)


def test_the_last_observation_of_an_episode_is_kept():
    same, following = vector(autoreset_mode=AutoresetMode.SAME_STEP), vector()
    # With this seed both balls are held to the end; a dropped one would be reset and end later.
    same.reset(seed=1), following.reset(seed=1)
    for _ in range(3):
        action = np.full((2, 1), 0.8, np.float32)
        first, second = same.step(action), following.step(action)
        assert not first[2].any() and not second[2].any()
    assert first[3].all() and second[3].all()
    for i in range(2):
        for name, value in first[4]["final_obs"][i].items():
            assert np.array_equal(value, second[0][name][i])
    after = following.step(action)
    assert all(np.array_equal(first[0][name], after[0][name]) for name in first[0])
    assert (after[1] == 0).all() and not after[3].any()


def test_results_are_copies_or_alternate():
    env = vector()
    env.reset(seed=1)
    a, b = env.step(np.zeros((2, 1)))[0], env.step(np.zeros((2, 1)))[0]
    assert not any(np.shares_memory(a[name], b[name]) for name in a)
    env = vector(copy=False)
    env.reset(seed=1)
    a, b = env.step(np.zeros((2, 1)))[0], env.step(np.zeros((2, 1)))[0]
    assert not any(np.shares_memory(a[name], b[name]) for name in a), "valid for one further step"
    c = env.step(np.zeros((2, 1)))[0]
    assert all(np.shares_memory(a[name], c[name]) for name in a)


def test_a_bad_action_names_its_environment():
    env = vector()
    env.reset(seed=1)
    with pytest.raises(ValueError, match="environment 1: its action contains NaN"):
        env.step(np.array([[0.0], [np.nan]]))
    with pytest.raises(ValueError, match=r"actions have shape \(3,\); allowed: \(2, 1\)"):
        env.step(np.zeros(3))
    env.step(np.zeros(2))


def test_actions_by_column_are_refused():
    env = tactus.VectorEnv(REGRASP, 3, objects=["sphere"], threads=2)
    env.reset(seed=1)
    size = env.single_action_space.shape[0]
    assert size != 3
    wrong = np.zeros((size, 3), np.float32)
    with pytest.raises(ValueError, match=rf"actions have shape \({size}, 3\); allowed: \(3, {size}\)"):
        env.step(wrong)
    with pytest.raises(ValueError, match="allowed"):
        env.step(wrong.reshape(-1))
    env.step(wrong.T)


def test_masked_reset_and_restore():
    env = vector(autoreset_mode=AutoresetMode.DISABLED)
    env.reset(seed=1)
    before = env.step(np.zeros((2, 1)))[0]
    saved = env.save(1)
    after, _ = env.reset(options={"reset_mask": np.array([False, True])})
    assert all(np.array_equal(before[name][0], after[name][0]) for name in before)
    assert any(not np.array_equal(before[name][1], after[name][1]) for name in before)
    again = env.restore(1, saved)
    assert all(np.array_equal(before[name], again[name]) for name in before)


def same(a, b):
    return all(np.array_equal(a[name], b[name]) for name in a)


def test_without_a_seed_episodes_differ_and_the_seed_is_told():
    envs = [tactus.Env(HOLD, objects=["sphere"], max_steps=3) for _ in range(4)]
    starts = [env.reset() for env in envs]
    assert not any(same(starts[i][0], starts[j][0]) for i in range(4) for j in range(i))
    seeds = [int(infos["seed"]) for _, infos in starts]
    assert len(set(seeds)) == 4 and seeds == [env.np_random_seed for env in envs]
    assert same(envs[0].reset(seed=seeds[2])[0], starts[2][0]), "who knows the seed has the episode"
    assert vector().np_random_seed != vector().np_random_seed
    assert vector(seed=5).np_random_seed == 5


def test_seeds_of_single_environments():
    env = vector()
    obs, infos = env.reset(seed=[3, 4])
    assert infos["seed"].tolist() == [3, 4]
    for i, seed in enumerate([3, 4]):
        alone, _ = tactus.Env(HOLD, objects=["sphere"], max_steps=3).reset(seed=seed)
        assert same(alone, {name: value[i] for name, value in obs.items()})
    after, infos = env.reset(seed=[None, 3])
    assert infos["seed"].tolist() == [3, 3]
    assert same({k: v[1] for k, v in after.items()}, {k: v[0] for k, v in obs.items()})
    assert same(env.reset(seed=9)[0], vector(seed=9).reset()[0]), "a number is for all, as ever"
    with pytest.raises(ValueError, match="3 seeds for 2 environments"):
        env.reset(seed=[1, 2, 3])
    for bad in [-1, 2**64]:
        with pytest.raises(ValueError, match=rf"seed {bad}; allowed: 0 to"):
            env.reset(seed=bad)


def test_modes_go_by_their_name():
    assert vector(autoreset_mode="SameStep").autoreset_mode == AutoresetMode.SAME_STEP
    with pytest.raises(ValueError, match="autoreset_mode 'Never'; allowed: 'NextStep', 'SameStep', 'Disabled'"):
        vector(autoreset_mode="Never")


def test_snapshots_that_do_not_fit_are_refused():
    env = vector()
    env.reset(seed=1)
    before = env.step(np.zeros((2, 1)))[0]
    saved = env.save(1)
    other = tactus.VectorEnv(REGRASP, 1, objects=["sphere"])
    other.reset(seed=1)
    middle = len(saved) // 2
    changed = saved[:middle] + bytes([saved[middle] ^ 1]) + saved[middle + 1 :]
    bad = {
        "cannot be read": [saved[:-9], b"", b"no snapshot"],
        "belongs to another scene": [other.save(0)],
        "checksum does not match": [changed],
    }
    for said, snapshots in bad.items():
        for snapshot in snapshots:
            with pytest.raises(ValueError, match=said):
                env.restore(1, snapshot)
    assert same(env.restore(1, saved), before)


def ahead(env, steps=4):
    rows = [env.step(np.full((2, 1), 0.3 * k - 0.5, np.float32)) for k in range(steps)]
    return [[row[0][name].tobytes() for name in row[0]] + [a.tobytes() for a in row[1:4]] for row in rows]


@pytest.mark.parametrize("again", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
@pytest.mark.parametrize("mode", list(AutoresetMode)[:2])
def test_copies_go_on_bit_for_bit(again, mode, monkeypatch, tmp_path):
    fresh = vector(seed=2, autoreset_mode=mode)
    assert same(again(fresh).reset()[0], fresh.reset()[0]), "before the first reset"
    fresh.step(np.zeros((2, 1)))
    monkeypatch.chdir(tmp_path)
    twin = again(fresh)
    assert ahead(twin) == ahead(fresh)
    assert twin.np_random_seed == 2
    one = tactus.Env(HOLD, objects=["sphere"], max_steps=3)
    one.reset(seed=5)
    twin = again(one)
    assert same(twin.step(np.zeros(1))[0], one.step(np.zeros(1))[0])


def test_pictures():
    env = tactus.Env(HOLD, objects=["sphere"], max_steps=3, render_mode="rgb_array")
    with pytest.raises(ValueError, match="no episode to draw"):
        env.render()
    env.reset(seed=1)
    first = env.render()
    assert first.shape == (800, 1400, 3) and first.dtype == np.uint8 and len(np.unique(first)) > 20
    env.step(np.ones(1))
    assert not np.array_equal(first, env.render())
    many = vector(render_mode="rgb_array")
    many.reset(seed=1)
    assert [picture.shape for picture in many.render()] == [(800, 1400, 3)] * 2
    assert vector().render() is None
    with pytest.raises(ValueError, match="render_mode 'human'"):
        vector(render_mode="human")


@pytest.mark.parametrize("name", ["Hold", "Squeeze", "Regrasp"])
def test_tasks_of_gymnasium(name):
    one = gym.make(f"tactus/{name}-v0", objects=["sphere"], render_mode="rgb_array")
    obs, _ = one.reset(seed=3)
    assert one.observation_space.contains(obs) and one.render().shape == (800, 1400, 3)
    one.step(one.action_space.sample())
    many = gym.make_vec(f"tactus/{name}-v0", num_envs=3, objects=["sphere"])
    assert isinstance(many.unwrapped, tactus.VectorEnv) and many.num_envs == 3
    obs, _ = many.reset(seed=3)
    assert many.observation_space.contains(obs)


@pytest.mark.parametrize("mode", list(AutoresetMode)[:2])
def test_returns_and_lengths_of_episodes_are_recorded(mode):
    env = gym.wrappers.vector.RecordEpisodeStatistics(vector(autoreset_mode=mode))
    env.reset(seed=1)
    paid, taken, fresh, ends = np.zeros(2), np.zeros(2, int), np.zeros(2, bool), 0
    for _ in range(8):
        _, reward, terminated, truncated, infos = env.step(np.full((2, 1), 0.8, np.float32))
        done = terminated | truncated
        paid, taken = paid + reward, taken + ~fresh
        if done.any():
            assert np.array_equal(infos["_episode"], done)
            assert np.allclose(infos["episode"]["r"][done], paid[done], atol=1e-6)
            assert np.array_equal(infos["episode"]["l"][done], taken[done])
        # A step that only resets does not belong to an episode.
        fresh = done & (mode == AutoresetMode.NEXT_STEP)
        paid[done], taken[done], ends = 0, 0, ends + done.sum()
    assert ends >= 4


def test_the_return_of_a_single_environment_is_recorded():
    env = gym.wrappers.RecordEpisodeStatistics(tactus.Env(HOLD, objects=["sphere"], max_steps=3))
    env.reset(seed=1)
    steps = [env.step(np.ones(1)) for _ in range(3)]
    assert [row[3] for row in steps] == [False, False, True]
    assert steps[-1][4]["episode"]["r"] == pytest.approx(sum(row[1] for row in steps))
    assert steps[-1][4]["episode"]["l"] == 3


def test_tasks_are_found_from_anywhere(tmp_path):
    script = "import gymnasium, tactus; gymnasium.make('tactus/Hold-v0', objects=['sphere']).reset(seed=1); print('good')"
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.stdout.strip() == "good", done.stderr


def test_a_copy_has_its_network_by_name_or_by_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert lasting("universe") == "universe" and lasting("model") == str(tmp_path / "model")
