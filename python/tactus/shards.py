"""Rollouts of many environments, and data sets, in shards: on this machine, or on all machines of a Ray cluster.

What an environment does depends on (seed, number of the environment) alone, so how the environments are cut into shards,
where a shard runs, and how often a machine fails on the way change no byte. A shard is a folder that appears under its name
when it is complete; what is there is not made again. So it is with the grasps of a data set.
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
    """The random actions of an environment: (steps, size)."""
    return np.random.Generator(np.random.Philox(key=[seed, env])).uniform(-1, 1, (steps, size)).astype(np.float32)


def shard(
    scene: str, out: str, first: int, count: int, steps: int, seed: int = 0, settings: dict[str, Any] | None = None
) -> str:
    """Rolls environments `first` to `first + count` out and writes them: (steps + 1, count, ...) per observation,
    (steps, count) of reward, terminated, truncated; as `.npy`. Returns the folder."""
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
        # Another worker was given the same shard and was faster; its bytes are the same.
        shutil.rmtree(part)
    return str(done)


def everywhere(work: Callable[..., Any], jobs: Sequence[tuple[Any, ...]], cluster: bool) -> list[Any]:
    """Does all jobs, here or in Ray tasks of one core each, which Ray starts again where a worker or a machine is lost."""
    if not cluster:
        return [work(*job) for job in jobs]
    import ray

    remote = ray.remote(num_cpus=1, max_retries=-1)(work)
    return list(ray.get([remote.remote(*job) for job in jobs]))


def part(scene: str, out: str, number: int, parts: int) -> int:
    """Makes part `number` (from 0) of a data set; returns how many grasps ran."""
    return _tactus.make(scene, out, (number, parts), 1)


def dataset(
    scene: str | os.PathLike[str], out: str | os.PathLike[str], *, parts: int = 8, cluster: bool = False
) -> int:
    """Makes the data set of a scene in `parts` parts and closes it; returns how many grasps ran. `cluster` as in
    :func:`rollout`."""
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
    """Rolls out `num_envs` environments under random actions. `cluster`: on the Ray cluster that is initialised; `out` and
    `scene` are then paths that all machines share."""
    scene, out = os.path.abspath(scene), os.path.abspath(out)
    os.makedirs(out, exist_ok=True)
    jobs = [
        (scene, out, first, min(per_shard, num_envs - first), steps, seed, settings)
        for first in range(0, num_envs, per_shard)
    ]
    done = everywhere(shard, jobs, cluster)
    for left in Path(out).glob(".shard_*"):
        # By a worker that was killed while it wrote.
        shutil.rmtree(left)
    return done
