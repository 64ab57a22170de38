"""Gymnasium environments of scenes with a task."""

from __future__ import annotations

import operator
import os
from typing import Any, Sequence

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from ._tactus import Batch
from .models import lasting

INFO = ("held", "slip", "slipped", "margin", "stress", "force", "load")

Array = npt.NDArray[Any]
Obs = dict[str, Any]
Picture = npt.NDArray[np.uint8]


class VectorEnv(gym.vector.VectorEnv[Obs, Array, Array]):
    """Batch of N environments of one scene, stepped in parallel in Rust.

    scene: scene file with a `task`.
    num_envs: number of environments.
    seed: seed of all episodes until `reset(seed=...)`; random numbers depend on (seed, environment, episode) alone.
      None uses a seed from the operating system (see `np_random_seed`).
    model: folder of a trained network; None uses the backend of the scene.
    autoreset_mode: mode of Gymnasium, or its name (`"SameStep"`).
    max_steps: maximum number of steps of an episode; None uses that of the scene.
    threads: number of threads; None uses all of the machine.
    objects: names of the objects to draw from; None uses all objects of the scene.
    first_env: index of the first environment, for shards of one batch.
    copy: True returns new arrays; False alternates between two sets of arrays, so that a result stays valid for one
      further step.
    render_mode: `"rgb_array"` renders like `tactus run`.

    Observations are a dictionary of float32 arrays in SI units (see `units`); actions are float32 from -1 to 1. `infos`
    contains, per environment, the quantities from which the reward was computed, and `fault`: the reason of a solver
    failure or an infeasible start, or None; after a reset also `seed`, the seed of the episodes.

    Copies (`copy.deepcopy`) and pickles store the scene file, the settings and the running episodes, and continue bit
    for bit. Ctrl-C during a call discards all episodes; the environments must then be reset. A forked process may
    continue to use the environments.
    """

    single_observation_space: spaces.Dict
    single_action_space: spaces.Box

    def __init__(
        self,
        scene: str | os.PathLike[str],
        num_envs: int = 1,
        *,
        seed: int | None = None,
        model: str | os.PathLike[str] | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        max_steps: int | None = None,
        threads: int | None = None,
        objects: Sequence[str] | None = None,
        first_env: int = 0,
        copy: bool = True,
        render_mode: str | None = None,
    ) -> None:
        mode = _autoreset(autoreset_mode)
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f'render_mode {render_mode!r}; allowed: None, "rgb_array"')
        seed = int(np.random.SeedSequence().generate_state(1, np.uint64)[0]) if seed is None else _seed(seed)
        objects = None if objects is None else list(objects)

        def made(scene: str, model: str | None) -> tuple[Any, ...]:
            return scene, num_envs, seed, mode.value, max_steps, threads, objects, first_env, model

        model = None if model is None else os.fspath(model)
        self._batch = Batch(*made(os.fspath(scene), model))
        # A copy may be created in another working directory.
        self._made = made(os.path.abspath(scene), None if model is None else lasting(model))
        self._np_random, self._np_random_seed = seeding.np_random(seed)
        self.num_envs = num_envs
        self.autoreset_mode = mode
        self.render_mode = render_mode
        self.metadata = {"autoreset_mode": mode, "render_modes": ["rgb_array"], "render_fps": 10}
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
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Obs, dict[str, Any]]:
        """Starts the next episodes, or the first ones of `seed`; `options["reset_mask"]` (num_envs, bool) selects
        environments.

        A list of seeds contains one per environment, which then starts the same episode as `Env` with that seed; None
        starts the next episode.
        """
        mask = (options or {}).get("reset_mask")
        if mask is not None:
            mask = np.asarray(mask)
            if mask.shape != (self.num_envs,) or mask.dtype != np.bool_:
                raise ValueError(f"reset_mask: {self.num_envs} booleans are allowed, found {mask.shape} {mask.dtype}")
            mask = mask.tolist()
        one, each = None, None
        if seed is None or hasattr(seed, "__index__"):
            one = None if seed is None else _seed(seed)
            super().reset(seed=one)
        else:
            each = [None if s is None else _seed(s) for s in seed]
            if len(each) != self.num_envs:
                raise ValueError(f"seed: {len(each)} seeds for {self.num_envs} environments")
        obs, *_ = self._next_arrays()
        self._batch.reset(one, each, mask, self._flat(obs))
        infos = self._infos()
        infos["seed"], infos["_seed"] = np.array(self._batch.seeds(), np.uint64), np.ones(self.num_envs, np.bool_)
        return obs, infos

    def step(self, actions: Array) -> tuple[Obs, Array, Array, Array, dict[str, Any]]:
        """Takes one step of every environment. Raises ValueError for an action that is not finite."""
        flat = self._actions(actions)
        obs, reward, terminated, truncated = self._next_arrays()
        self._batch.step(flat, self._flat(obs), reward, terminated, truncated)
        infos = self._infos()
        ended = terminated | truncated
        if self.autoreset_mode == AutoresetMode.SAME_STEP and ended.any():
            final = self._arrays()[0]
            self._batch.final_obs(self._flat(final))
            rows = [{name: a[i].copy() for name, a in final.items()} if ended[i] else None for i in range(self.num_envs)]
            infos["final_obs"], infos["_final_obs"] = np.empty(self.num_envs, dtype=object), ended.copy()
            infos["final_obs"][:] = rows
            info = {k: v for k, v in infos.items() if not k.startswith(("_", "final"))}
            infos["final_info"] = info | {f"_{k}": ended.copy() for k in info}
            infos["_final_info"] = ended.copy()
        return obs, reward, terminated, truncated, infos

    def save(self, env: int) -> bytes:
        """Returns the state of an environment, from which it can be restored bit for bit."""
        return self._batch.save(env)

    def restore(self, env: int, snapshot: bytes) -> Obs:
        """Restores an environment to the state of `snapshot`; returns the observations of all environments. Raises
        ValueError for a snapshot that is damaged or of another scene."""
        obs, *_ = self._next_arrays()
        self._batch.restore(env, snapshot, self._flat(obs))
        return obs

    def held_objects(self) -> list[str | None]:
        """Returns the object name of each environment; None without an episode."""
        return self._batch.held_objects()

    def render(self) -> tuple[Picture, ...] | None:
        """Returns the picture of each environment, (height, width, 3); None without `render_mode="rgb_array"`."""
        if self.render_mode is None:
            return None
        return tuple(self._batch.render(env) for env in range(self.num_envs))

    def __getstate__(self) -> dict[str, Any]:
        state = self.__dict__.copy()
        batch: Batch = state.pop("_batch")
        state["snapshots"] = [batch.save(env) if begun else None for env, begun in enumerate(batch.begun())]
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        snapshots = state.pop("snapshots")
        self.__dict__.update(state)
        self._batch = Batch(*self._made)
        obs = self._flat(self._arrays()[0])
        for env, snapshot in enumerate(snapshots):
            if snapshot is not None:
                self._batch.restore(env, snapshot, obs)

    def _actions(self, actions: Array) -> npt.NDArray[np.float32]:
        rows = np.asarray(actions, dtype=np.float32)
        wanted = (self.num_envs, self._batch.action_size())
        if rows.shape != wanted and not (wanted[1] == 1 and rows.shape == wanted[:1]):
            raise ValueError(f"actions have shape {rows.shape}; allowed: {wanted}, one row for each environment")
        return np.ascontiguousarray(rows).reshape(-1)

    def _infos(self) -> dict[str, Any]:
        columns = np.array(self._batch.info(), dtype=np.float64).reshape(self.num_envs, len(INFO)).T
        every = np.ones(self.num_envs, dtype=np.bool_)
        infos: dict[str, Any] = {}
        for name, column in zip(INFO, columns):
            infos[name], infos[f"_{name}"] = column.astype(np.bool_) if name == "held" else column.copy(), every
        faults = self._batch.faults()
        infos["fault"] = np.array(faults, dtype=object)
        infos["_fault"] = np.array([fault is not None for fault in faults])
        return infos

    def _arrays(self) -> tuple[Obs, Array, Array, Array]:
        n = self.num_envs
        obs = {name: np.zeros((n, *_shape(space)), np.float32) for name, space in self.single_observation_space.items()}
        return obs, np.zeros(n, np.float32), np.zeros(n, np.bool_), np.zeros(n, np.bool_)

    def _next_arrays(self) -> tuple[Obs, Array, Array, Array]:
        if self._sets is None:
            return self._arrays()
        self._sets.reverse()
        return self._sets[0]

    def _flat(self, obs: Obs) -> list[Array]:
        return [obs[name].reshape(-1) for name in self._order]


class Env(gym.Env[Obs, Array]):
    """Single environment of a scene, with the settings of `VectorEnv`."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(self, scene: str | os.PathLike[str], **settings: Any) -> None:
        self._batch = VectorEnv(scene, 1, autoreset_mode=AutoresetMode.DISABLED, **settings)
        self.render_mode = self._batch.render_mode
        self.observation_space = self._batch.single_observation_space
        self.action_space = self._batch.single_action_space
        self._np_random, self._np_random_seed = self._batch.np_random, self._batch.np_random_seed

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Obs, dict[str, Any]]:
        super().reset(seed=seed)
        obs, infos = self._batch.reset(seed=seed)
        return self._first(obs), self._first(infos)

    def step(self, action: Array) -> tuple[Obs, float, bool, bool, dict[str, Any]]:
        obs, reward, terminated, truncated, infos = self._batch.step(np.asarray(action)[None])
        return self._first(obs), float(reward[0]), bool(terminated[0]), bool(truncated[0]), self._first(infos)

    def render(self) -> Picture | None:
        """Returns the picture, (height, width, 3); None without `render_mode="rgb_array"`."""
        pictures = self._batch.render()
        return None if pictures is None else pictures[0]

    @staticmethod
    def _first(arrays: dict[str, Any]) -> dict[str, Any]:
        return {name: array[0] for name, array in arrays.items() if not name.startswith("_")}


def _autoreset(mode: AutoresetMode | str) -> AutoresetMode:
    try:
        return AutoresetMode(mode)
    except ValueError:
        allowed = ", ".join(repr(m.value) for m in AutoresetMode)
        raise ValueError(f"autoreset_mode {mode!r}; allowed: {allowed}, or AutoresetMode") from None


def _shape(space: spaces.Space[Any]) -> tuple[int, ...]:
    return space.shape or ()


def _seed(seed: Any) -> int:
    number = operator.index(seed)
    if not 0 <= number < 2**64:
        raise ValueError(f"seed {number}; allowed: 0 to 2**64 - 1")
    return number
