"""The tasks that ship with tactus, under the names that `gymnasium.make` and `gymnasium.make_vec` take."""

from __future__ import annotations

from pathlib import Path

import gymnasium as gym

TASKS = {"tactus/Hold-v0": "hold.ron", "tactus/Squeeze-v0": "squeeze.ron", "tactus/Regrasp-v0": "regrasp.ron"}


def register() -> None:
    """Enters the tasks in Gymnasium's registry; further settings are those of `Env` and `VectorEnv`."""
    for name, file in TASKS.items():
        if name not in gym.registry:
            gym.register(
                name,
                entry_point="tactus.env:Env",
                vector_entry_point="tactus.env:VectorEnv",
                kwargs={"scene": str(Path(__file__).parent / "tasks" / file)},
            )
