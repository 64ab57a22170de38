"""Registration of the included tasks for `gymnasium.make` and `gymnasium.make_vec`."""

from __future__ import annotations

from pathlib import Path

import gymnasium as gym

TASKS = {"tactus/Hold-v0": "hold.ron", "tactus/Squeeze-v0": "squeeze.ron", "tactus/Regrasp-v0": "regrasp.ron"}


def register() -> None:
    """Adds the tasks to the registry of Gymnasium; further settings are those of `Env` and `VectorEnv`."""
    for name, file in TASKS.items():
        if name not in gym.registry:
            gym.register(
                name,
                entry_point="tactus.env:Env",
                vector_entry_point="tactus.env:VectorEnv",
                kwargs={"scene": str(Path(__file__).parent / "tasks" / file)},
            )
