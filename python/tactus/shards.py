"""Sharded rollouts of many environments, and sharded data sets, on this machine or on a Ray cluster.

The trajectory of an environment depends on (seed, index of the environment) alone. Results are therefore identical,
byte for byte, for any partition into shards, any placement of shards and any number of machine failures. A shard is a
folder that gets its final name when it is complete; existing shards are not computed again. The same holds for the
grasps of a data set.
"""

from __future__ import annotations

import os
import shutil
import uuid
from pathlib import Path
from typing import Any, Callable, Sequence

import numpy as np

from . import _tactus
from .env import VectorEnv


def actions(seed: int, env: int, steps: int, size: int) -> np.ndarray:
    """Returns the random actions of an environment: (steps, size)."""
    return np.random.Generator(np.random.Philox(key=[seed, env])).uniform(-1, 1, (steps, size)).astype(np.float32)


def shard(
    scene: str, out: str, first: int, count: int, steps: int, seed: int = 0, settings: dict[str, Any] | None = None
) -> str:
    """Rolls out the environments from `first` to `first + count` (exclusive) and writes `.npy` files:
    (steps + 1, count, ...) per observation, (steps, count) for reward, terminated and truncated. Returns the folder."""
    done = Path(out) / f"shard_{first:06}"
    if done.exists():
        return str(done)
    env = VectorEnv(scene, count, seed=seed, first_env=first, threads=1, **(settings or {}))
    size = env.single_action_space.shape[0]
    acts = np.stack([actions(seed, first + i, steps, size) for i in range(count)], axis=1)
    rows = {name: [value] for name, value in env.reset(seed=seed)[0].items()}
    rest: dict[str, list[np.ndarray]] = {"reward": [], "terminated": [], "truncated": []}
    for step in range(steps):
        obs, *values, _ = env.step(acts[step])
        for name, value in obs.items():
            rows[name].append(value)
        for name, value in zip(rest, values):
            rest[name].append(value)
    part = done.with_name(f".{done.name}.{uuid.uuid4().hex}")
    part.mkdir(parents=True)
    for name, values in {**rows, **rest, "action": list(acts)}.items():
        np.save(part / f"{name}.npy", np.stack(values))
    try:
        os.rename(part, done)
    except OSError:
        # Another worker finished the same shard first; its content is identical.
        shutil.rmtree(part)
    return str(done)


def everywhere(work: Callable[..., Any], jobs: Sequence[tuple[Any, ...]], cluster: bool) -> list[Any]:
    """Runs all jobs, in this process or as Ray tasks of one core each, which Ray restarts if a worker or a machine
    fails."""
    if not cluster:
        return [work(*job) for job in jobs]
    import ray

    remote = ray.remote(num_cpus=1, max_retries=-1)(work)
    return list(ray.get([remote.remote(*job) for job in jobs]))


def part(scene: str, out: str, number: int, parts: int) -> int:
    """Computes part `number` (from 0) of a data set; returns the number of computed grasps."""
    return _tactus.make(scene, out, (number, parts), 1)


def dataset(
    scene: str | os.PathLike[str], out: str | os.PathLike[str], *, parts: int = 8, cluster: bool = False
) -> int:
    """Computes the data set of a scene in `parts` parts and finishes it; returns the number of computed grasps.
    `cluster` as in :func:`rollout`."""
    scene, out = os.path.abspath(scene), os.path.abspath(out)
    ran = everywhere(part, [(scene, out, number, parts) for number in range(parts)], cluster)
    return int(sum(ran)) + _tactus.make(scene, out, None, 1)


def rollout(
    scene: str | os.PathLike[str],
    out: str | os.PathLike[str],
    num_envs: int,
    steps: int,
    *,
    per_shard: int = 16,
    seed: int = 0,
    cluster: bool = False,
    **settings: Any,
) -> Sequence[str]:
    """Rolls out `num_envs` environments under random actions; returns the folders of the shards. With `cluster` the
    shards run on the initialised Ray cluster, and `out` and `scene` must be on a file system shared by all machines."""
    scene, out = os.path.abspath(scene), os.path.abspath(out)
    os.makedirs(out, exist_ok=True)
    jobs = [
        (scene, out, first, min(per_shard, num_envs - first), steps, seed, settings)
        for first in range(0, num_envs, per_shard)
    ]
    done = everywhere(shard, jobs, cluster)
    for left in Path(out).glob(".shard_*"):
        # Incomplete shard of a killed worker.
        shutil.rmtree(left)
    return done
