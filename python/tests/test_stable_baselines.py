"""Environments for Stable-Baselines3, if it is installed (with PyTorch)."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import tactus

ROOT = Path(__file__).parents[2]
HOLD = ROOT / "scenes" / "tasks" / "hold.ron"
SETTINGS = dict(objects=["sphere"], max_steps=3, threads=2)


@pytest.fixture
def adapter():
    pytest.importorskip("torch", reason="PyTorch is not installed")
    pytest.importorskip("stable_baselines3", reason="Stable-Baselines3 is not installed")
    import tactus.stable_baselines

    return tactus.stable_baselines


def test_what_to_install_is_said_where_it_is_missing():
    code = """
import sys
sys.modules["stable_baselines3"] = None
try:
    import tactus.stable_baselines
except ImportError as error:
    assert 'pip install "./python[sb3]"' in str(error), error
else:
    raise AssertionError("there is no Stable-Baselines3")
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_steps_are_those_of_the_vector_environment(adapter):
    env, plain = adapter.VecEnv(HOLD, 2, **SETTINGS), tactus.VectorEnv(HOLD, 2, autoreset_mode="SameStep", **SETTINGS)
    env.seed(3)
    obs, (expected, _) = env.reset(), plain.reset(seed=[3, 4])
    assert all(np.array_equal(obs[name], expected[name]) for name in expected)
    ends = 0
    for step in range(5):
        action = np.full((2, 1), 0.2 * step, np.float32)
        obs, reward, done, infos = env.step(action)
        expected, paid, terminated, truncated, told = plain.step(action)
        assert all(np.array_equal(obs[name], expected[name]) for name in expected)
        assert np.array_equal(reward, paid) and np.array_equal(done, terminated | truncated)
        for i, info in enumerate(infos):
            assert info["margin"] == told["margin"][i] and info["TimeLimit.truncated"] == (truncated[i] and not terminated[i])
            if done[i]:
                last = info["terminal_observation"]
                assert all(np.array_equal(last[name], value) for name, value in told["final_obs"][i].items())
        ends += done.sum()
    assert ends >= 2
    with pytest.raises(AttributeError, match="step together in Rust"):
        env.set_attr("seed", 1)


def test_ppo_learns_a_few_steps_and_predicts(adapter):
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

    env = VecNormalize(VecMonitor(adapter.VecEnv(HOLD, 2, **SETTINGS)))
    agent = PPO("MultiInputPolicy", env, n_steps=8, batch_size=8, n_epochs=1, seed=1, device="cpu").learn(16)
    assert agent.num_timesteps == 16 and len(agent.ep_info_buffer) >= 4
    assert env.action_space.contains(agent.predict(env.reset(), deterministic=True)[0][0])
