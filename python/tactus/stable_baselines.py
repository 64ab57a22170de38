"""Environments of a scene for Stable-Baselines3."""

from __future__ import annotations

import os
from typing import Any, Iterable, Sequence

from gymnasium.vector import AutoresetMode

from .env import Array, Obs, Picture, VectorEnv

try:
    from stable_baselines3.common import vec_env
except ImportError as error:
    raise ImportError('tactus.stable_baselines needs Stable-Baselines3; run: pip install "./python[sb3]"') from error


class VecEnv(vec_env.VecEnv):
    """Vectorised environments of a scene for the algorithms of Stable-Baselines3, with `"MultiInputPolicy"`.

    settings: settings of `VectorEnv`, except `autoreset_mode`, which Stable-Baselines3 fixes.

    Observations are a dictionary of float32 arrays (num_envs, ...) in SI units. Each info contains the quantities from
    which the reward was computed and `TimeLimit.truncated`, and at the end of an episode `terminal_observation`.
    """

    def __init__(self, scene: str | os.PathLike[str], num_envs: int = 1, **settings: Any) -> None:
        self.vector = VectorEnv(scene, num_envs, autoreset_mode=AutoresetMode.SAME_STEP, **settings)
        super().__init__(num_envs, self.vector.single_observation_space, self.vector.single_action_space)

    def reset(self) -> Obs:
        """Starts the next episodes, or those of the seeds set by `seed`."""
        seeds = None if all(seed is None for seed in self._seeds) else self._seeds
        obs, infos = self.vector.reset(seed=seeds)
        self.reset_infos = self._rows(infos)
        self._reset_seeds()
        return obs

    def step_async(self, actions: Array) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[Obs, Array, Array, list[dict[str, Any]]]:
        obs, reward, terminated, truncated, infos = self.vector.step(self._actions)
        rows = self._rows(infos)
        for i, row in enumerate(rows):
            row["TimeLimit.truncated"] = bool(truncated[i] and not terminated[i])
            if terminated[i] or truncated[i]:
                row["terminal_observation"] = infos["final_obs"][i]
        return obs, reward, terminated | truncated, rows

    def close(self) -> None:
        self.vector.close()

    def get_images(self) -> Sequence[Picture | None]:
        return self.vector.render() or [None] * self.num_envs

    def get_attr(self, attr_name: str, indices: None | int | Iterable[int] = None) -> list[Any]:
        return [getattr(self.vector, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: None | int | Iterable[int] = None) -> None:
        raise AttributeError(f"{attr_name}: the environments step together in Rust; differences between them are defined in the scene")

    def env_method(
        self, method_name: str, *method_args: Any, indices: None | int | Iterable[int] = None, **method_kwargs: Any
    ) -> list[Any]:
        raise AttributeError(f"{method_name}: the environments step together in Rust; call it on `vector`")

    def env_is_wrapped(self, wrapper_class: type[Any], indices: None | int | Iterable[int] = None) -> list[bool]:
        return [False for _ in self._get_indices(indices)]

    def _rows(self, infos: dict[str, Any]) -> list[dict[str, Any]]:
        names = [name for name in infos if not name.startswith(("_", "final"))]
        return [{name: infos[name][i] for name in names} for i in range(self.num_envs)]
