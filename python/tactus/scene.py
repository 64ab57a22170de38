"""Scene files: what they say, and what their grasps do."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

from . import _tactus


@dataclass(frozen=True)
class Scene:
    """A checked scene file."""

    path: str
    objects: tuple[str, ...]

    def ron(self, object: str | None = None) -> str:
        """The scene of one object with every default written out."""
        return _tactus.resolved(self.path, object)


def load(path: str | os.PathLike[str]) -> Scene:
    """Loads and checks a scene file; ValueError with file, line, column and what is allowed if it is wrong."""
    path = os.fspath(path)
    return Scene(path, tuple(_tactus.objects(path)))


def run(
    scene: Scene | str | os.PathLike[str],
    object: str | None = None,
    model: str | os.PathLike[str] | None = None,
    threads: int | None = None,
) -> list[dict[str, Any]]:
    """Simulates all grasps of a scene; `model` is the folder of a trained network, None the scene's backend.

    A dictionary per grasp: `status` (reached, dropped, fault, infeasible), `reason`, `wall_s`, and by frame `force_n` (F),
    `travel_m` (F, pads), `object_pose` (F, 7), `wrench` (F, pads, 6), `position_m`, `displacement_m`, `contact_force_n`
    (F, pads, nodes, 3) and `von_mises_pa` (F, pads, nodes) where the scene records them; all in the hand frame. A network
    adds `displacement_error`, `stress_error` and `travel_error` (F): nine of ten such predictions are off by less.
    """
    path = scene.path if isinstance(scene, Scene) else os.fspath(scene)
    return _tactus.run(path, object, None if model is None else os.fspath(model), threads or os.cpu_count() or 1)
