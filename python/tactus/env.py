"""Scenes with a task as environments of Gymnasium."""

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
    """N environments of one scene, stepped together in Rust.

    scene: scene file with a `task`.
    num_envs: number of environments.
    seed: of all episodes until `reset(seed=...)`; what is drawn depends on (seed, environment, episode) alone; None draws a
      seed from the system, which `np_random_seed` tells.
    model: folder of a trained network; None takes the scene's backend.
    autoreset_mode: Gymnasium's, or its name (`"SameStep"`).
    max_steps: of an episode, in place of the scene's.
    threads: number; all of the machine if None.
    objects: names of the scene's objects to draw from.
    first_env: number of the first environment, for shards of one batch.
    copy: True gives arrays of your own; False alternates between two sets of arrays, so that a result stays valid for one
      further step.
    render_mode: `"rgb_array"` draws what `tactus run` draws.

    Observations are a dictionary of float32 arrays in SI (`units` names the unit of each); actions are float32 from -1
    to 1. `infos` holds, per environment, what the reward was made of and `fault`: why the solver gave up, or None; after a
    reset also `seed`, which the environment's episodes are drawn by.

    Copies (`copy.deepcopy`) and pickles hold scene file, settings and the running episodes, and go on bit for bit. Ctrl-C
    during a call leaves all environments without an episode: reset them. A forked process may go on with them.
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
        # A copy may be made in another folder.
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
        """Starts the next episodes, or with `seed` the first ones; `options["reset_mask"]` (num_envs, bool) chooses.

        A list of seeds has one for each environment, which then starts the episode that `Env` starts with that seed; where
        it is None, the next one.
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
        """One step of every environment. ValueError names the environment whose action is not finite."""
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
        """The state of an environment, to restore it bit for bit."""
        return self._batch.save(env)

    def restore(self, env: int, snapshot: bytes) -> Obs:
        """Brings an environment to where `snapshot` was saved; the observations of all. ValueError for a snapshot that is
        damaged or of another scene."""
        obs, *_ = self._next_arrays()
        self._batch.restore(env, snapshot, self._flat(obs))
        return obs

    def held_objects(self) -> list[str | None]:
        """Name of the object that each environment holds."""
        return self._batch.held_objects()

    def render(self) -> tuple[Picture, ...] | None:
        """The picture of every environment, (height, width, 3); None without `render_mode="rgb_array"`."""
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
    """One environment of a scene, with the settings of `VectorEnv`."""

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
        """The picture, (height, width, 3); None without `render_mode="rgb_array"`."""
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
