"""The environments as Gymnasium wants them, on the FEM backend (the network's contract is tested in Rust)."""

from pathlib import Path

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import tactus

HOLD = Path(__file__).parents[2] / "scenes" / "tasks" / "hold.ron"


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
    # Both balls of this seed are held to the end; a lost one would begin anew and end later.
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
    with pytest.raises(ValueError, match="environment 1: its action holds NaN"):
        env.step(np.array([[0.0], [np.nan]]))
    with pytest.raises(ValueError, match="3 numbers for 2 environments with 1 each"):
        env.step(np.zeros(3))


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
