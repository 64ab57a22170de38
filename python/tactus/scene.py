"""Scene files: what they say, and what their grasps do."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

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


def predict(
    scene: Scene | str | os.PathLike[str],
    object: str | None = None,
    model: str | os.PathLike[str] = "universe",
    poses: npt.ArrayLike | None = None,
    frames: int | None = None,
    extrapolate: bool = False,
    threads: int | None = None,
) -> dict[str, Any]:
    """Predicts the grasps of a scene by a trained network, all at once; those at `poses` if they are given: (G, 7), px py
    pz qw qx qy qz of the hand in the object frame.

    Returns float32 arrays over the G grasps that have an answer, whose numbers are `grasp` (G): `force_n` (F), `rest_m` (nodes, 3);
    `travel_m` (G, F, pads), `object_pose` (G, F, 7), `displacement_error`, `stress_error`, `travel_error` (G, F), below which nine of ten
    predictions stay; in the frame of each pad `displacement_m`, `contact_force_n` (G, F, pads, nodes, 3) and, where the scene records it,
    `von_mises_pa` (G, F, pads, nodes). `slip_margin` (G) is the part of what friction holds that the loads leave at the worst: below zero
    the object slips. `failed` is a dictionary from the number of a grasp without an answer to the reason.
    """
    path = scene.path if isinstance(scene, Scene) else os.fspath(scene)
    rows = None if poses is None else np.atleast_2d(np.asarray(poses, dtype=np.float64))
    return _tactus.predict(path, object, os.fspath(model), rows, frames, extrapolate, threads or os.cpu_count() or 1)
