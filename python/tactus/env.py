"""Scenes with a task as environments of Gymnasium."""

from __future__ import annotations

import os
from typing import Any, Sequence

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from ._tactus import Batch

FACTS = ("held", "slip", "slipped", "margin", "stress", "force", "load")


class VectorEnv(gym.vector.VectorEnv):
    """N environments of one scene, stepped together in Rust.

    scene: scene file with a `task`. model: folder of a trained network; None takes the scene's backend. seed: of all
    episodes until `reset(seed=...)`; what is drawn depends on (seed, environment, episode) alone. objects: names of the
    scene's objects to draw from. first_env: number of the first environment, for shards of one batch. copy: True gives
    arrays of your own; False alternates between two sets of arrays, so that a result stays valid for one further step.

    Observations are a dictionary of float32 arrays in SI (`units` names the unit of each); actions are float32 from -1
    to 1. `infos` holds, per environment, what the reward was made of and `fault`: why the solver gave up, or None.
    """

    def __init__(
        self,
        scene: str | os.PathLike[str],
        num_envs: int = 1,
        *,
        seed: int = 0,
        model: str | os.PathLike[str] | None = None,
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
        max_steps: int | None = None,
        threads: int | None = None,
        objects: Sequence[str] | None = None,
        first_env: int = 0,
        copy: bool = True,
    ) -> None:
        mode = {
            AutoresetMode.NEXT_STEP: "NextStep",
            AutoresetMode.SAME_STEP: "SameStep",
            AutoresetMode.DISABLED: "Disabled",
        }[autoreset_mode]
        model = None if model is None else os.fspath(model)
        objects = None if objects is None else list(objects)
        self._batch = Batch(os.fspath(scene), num_envs, seed, mode, max_steps, threads, objects, first_env, model)
        self.num_envs = num_envs
        self.autoreset_mode = autoreset_mode
        self.metadata = {"autoreset_mode": autoreset_mode, "render_modes": []}
        spec = self._batch.observation_spec()
        self.units = {name: unit for name, _, unit, _, _ in spec}
        self.single_observation_space = spaces.Dict(
            {name: spaces.Box(low, high, tuple(shape), np.float32) for name, shape, _, low, high in spec}
        )
        self.single_action_space = spaces.Box(-1.0, 1.0, (self._batch.action_size(),), np.float32)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._copy = copy
        self._sets = None if copy else [self._arrays(), self._arrays()]
        self._order = [name for name, *_ in spec]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Starts the next episodes, or with `seed` the first ones; `options["reset_mask"]` (num_envs, bool) chooses."""
        mask = (options or {}).get("reset_mask")
        if mask is not None:
            mask = np.asarray(mask)
            if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
                raise ValueError(f"reset_mask: {self.num_envs} booleans are allowed, found {mask.shape} {mask.dtype}")
            mask = mask.tolist()
        obs, *_ = arrays = self._next_arrays()
        self._batch.reset(seed, mask, self._flat(obs))
        return arrays[0], self._infos()

    def step(
        self, actions: np.ndarray
    ) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """One step of every environment. ValueError names the environment whose action is not finite."""
        actions = np.ascontiguousarray(actions, dtype=np.float32).reshape(-1)
        obs, reward, terminated, truncated = self._next_arrays()
        self._batch.step(actions, self._flat(obs), reward, terminated, truncated)
        infos = self._infos()
        ended = terminated | truncated
        if self.autoreset_mode == AutoresetMode.SAME_STEP and ended.any():
            final = self._arrays()[0]
            self._batch.final_obs(self._flat(final))
            rows = [{name: a[i].copy() for name, a in final.items()} if ended[i] else None for i in range(self.num_envs)]
            infos["final_obs"], infos["_final_obs"] = np.empty(self.num_envs, dtype=object), ended.copy()
            infos["final_obs"][:] = rows
            facts = {k: v for k, v in infos.items() if not k.startswith(("_", "final"))}
            infos["final_info"] = facts | {f"_{k}": ended.copy() for k in facts}
            infos["_final_info"] = ended.copy()
        return obs, reward, terminated, truncated, infos

    def save(self, env: int) -> str:
        """The running episode of an environment, to restore it bit for bit."""
        return self._batch.save(env)

    def restore(self, env: int, snapshot: str) -> dict[str, np.ndarray]:
        """Brings an environment to where `snapshot` was saved; the observations of all."""
        obs, *_ = self._next_arrays()
        self._batch.restore(env, snapshot, self._flat(obs))
        return obs

    def held_objects(self) -> list[str | None]:
        """Name of the object that each environment holds."""
        return self._batch.held_objects()

    def _infos(self) -> dict[str, Any]:
        columns = np.array(self._batch.facts(), dtype=np.float64).reshape(self.num_envs, len(FACTS)).T
        every = np.ones(self.num_envs, dtype=np.bool_)
        infos: dict[str, Any] = {}
        for name, column in zip(FACTS, columns):
            infos[name], infos[f"_{name}"] = column.astype(np.bool_) if name == "held" else column.copy(), every
        faults = self._batch.faults()
        infos["fault"] = np.array(faults, dtype=object)
        infos["_fault"] = np.array([fault is not None for fault in faults])
        return infos

    def _arrays(self) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray, np.ndarray]:
        n = self.num_envs
        obs = {name: np.zeros(space.shape, np.float32) for name, space in self.observation_space.spaces.items()}
        return obs, np.zeros(n, np.float32), np.zeros(n, np.bool_), np.zeros(n, np.bool_)

    def _next_arrays(self) -> tuple[dict[str, np.ndarray], np.ndarray, np.ndarray, np.ndarray]:
        if self._sets is None:
            return self._arrays()
        self._sets.reverse()
        return self._sets[0]

    def _flat(self, obs: dict[str, np.ndarray]) -> list[np.ndarray]:
        return [obs[name].reshape(-1) for name in self._order]


class Env(gym.Env):
    """One environment of a scene."""

    metadata = {"render_modes": []}

    def __init__(self, scene: str | os.PathLike[str], **settings: Any) -> None:
        self._batch = VectorEnv(scene, 1, autoreset_mode=AutoresetMode.DISABLED, **settings)
        self.observation_space = self._batch.single_observation_space
        self.action_space = self._batch.single_action_space

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        super().reset(seed=seed)
        obs, infos = self._batch.reset(seed=seed)
        return self._first(obs), self._first(infos)

    def step(self, action: np.ndarray) -> tuple[dict[str, np.ndarray], float, bool, bool, dict[str, Any]]:
        obs, reward, terminated, truncated, infos = self._batch.step(np.asarray(action)[None])
        return self._first(obs), float(reward[0]), bool(terminated[0]), bool(truncated[0]), self._first(infos)

    @staticmethod
    def _first(arrays: dict[str, Any]) -> dict[str, Any]:
        return {name: array[0] for name, array in arrays.items() if not name.startswith("_")}
