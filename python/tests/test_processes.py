"""Environments in child processes for every start method; a forked child lacks the threads of its parent."""

import multiprocessing
import os
from pathlib import Path

import gymnasium as gym
import numpy as np
import pytest

import tactus

HOLD = Path(__file__).parents[2] / "scenes" / "tasks" / "hold.ron"
SETTINGS = dict(objects=["sphere"], max_steps=3, threads=2)
# Timeout, s; every operation takes less than a tenth of it.
LIMIT = 120

START = ["fork", "spawn", "forkserver"]


def play(env):
    """Returns the observations of a short episode as bytes."""
    obs, _ = env.reset(seed=7)
    rows = [obs] + [env.step(np.full((2, 1), 0.5, np.float32))[0] for _ in range(2)]
    return b"".join(row[name].tobytes() for row in rows for name in sorted(row))


def in_child(env, to):
    to.put(play(env if env is not None else tactus.VectorEnv(HOLD, 2, **SETTINGS)))


def simulate(_):
    return [g.status for g in tactus.run(HOLD, object="sphere", threads=2)]


def used():
    env = tactus.VectorEnv(HOLD, 2, **SETTINGS)
    return env, play(env)


@pytest.mark.parametrize("start", START)
@pytest.mark.parametrize("inherited", [False, True])
def test_a_child_plays_what_its_parent_played(start, inherited):
    env, expected = used()
    context = multiprocessing.get_context(start)
    to = context.Queue()
    child = context.Process(target=in_child, args=(env if inherited else None, to))
    child.start()
    try:
        assert to.get(timeout=LIMIT) == expected
        child.join(timeout=LIMIT)
        assert child.exitcode == 0
    finally:
        child.kill()
    assert play(env) == expected, "the parent goes on"


@pytest.mark.parametrize("start", START)
def test_a_pool_runs_scenes(start):
    used()
    with multiprocessing.get_context(start).Pool(2) as pool:
        assert pool.map_async(simulate, range(2)).get(timeout=LIMIT) == [["reached"] * 2] * 2


@pytest.mark.parametrize("start", START)
def test_environments_of_gymnasium_in_processes(start):
    used()
    env = gym.make_vec("tactus/Hold-v0", 2, vectorization_mode="async", vector_kwargs={"context": start}, **SETTINGS)
    try:
        env.reset_async(seed=[1, 2])
        obs, infos = env.reset_wait(timeout=LIMIT)
        assert infos["seed"].tolist() == [1, 2]
        env.step_async(np.zeros((2, 1), np.float32))
        assert env.step_wait(timeout=LIMIT)[1].shape == (2,)
        alone = tactus.Env(HOLD, **SETTINGS)
        row, _ = alone.reset(seed=2)
        assert all(np.array_equal(obs[name][1], row[name]) for name in row)
    finally:
        env.close(terminate=True)


def work(remote, make):
    """Acts as a worker of Stable-Baselines3's SubprocVecEnv."""
    env = make()
    obs, _ = env.reset(seed=1)
    remote.send((os.getpid(), {name: value.tobytes() for name, value in obs.items()}))


@pytest.mark.parametrize("start", START)
def test_workers_that_make_their_environment(start):
    used()
    context = multiprocessing.get_context(start)
    seen = []
    for _ in range(2):
        mine, theirs = context.Pipe()
        child = context.Process(target=work, args=(theirs, make), daemon=True)
        child.start()
        assert mine.poll(LIMIT), "it hangs"
        seen.append(mine.recv()[1])
        child.join(timeout=LIMIT)
    assert seen[0] == seen[1]


def make():
    return tactus.Env(HOLD, **SETTINGS)
