"""A network's answers to many grasps: `tactus.predict` and what it returns."""

from __future__ import annotations

import logging
import os
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from . import _tactus
from .meshes import Indices, Pad, Surface

F32 = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False, repr=False)
class Predictions:
    """A network's answers to the grasps of a scene: those `G` that have one, at `F` loads. `P` pads, left first, `n` nodes of each.

    grasp: (G), numbers of the grasps.
    failed: the reason by the number of each grasp without an answer.
    notices: what to know before an answer is trusted, as logged: frames without an answer, and where the error is unknown.
    pads: rest meshes of the pads.
    object: surface of the object.
    force_n: (F), N, sum over the fingers of |normal force|.
    travel_m: (G, F, P), m, closing travel of each finger since first contact.
    object_pose: (G, F, 7), m and 1, of the object in the hand: px py pz qw qx qy qz.
    displacement_m: (G, F, P, n, 3), m, in the frame of each pad, as the contact force.
    contact_force_n: (G, F, P, n, 3), N, on the pad.
    slip_margin: (G), part of what friction holds that the loads leave at the worst; below zero the object slips.
    von_mises_pa: (G, F, P, n), Pa; None where the scene does not record it.
    displacement_error, stress_error, travel_error: (G, F), relative, what nine of ten predictions stay below; infinite where
      it is unknown: outside the range of the training, or of a network that was trained on few grasps.
    tactile: arrays of the tactile sensors that the scene records, by name: (G, F, P, ...), as of a run.
    """

    grasp: Indices
    failed: dict[int, str]
    notices: tuple[str, ...]
    pads: tuple[Pad, ...]
    object: Surface
    force_n: F32
    travel_m: F32
    object_pose: F32
    displacement_m: F32
    contact_force_n: F32
    slip_margin: F32
    tactile: dict[str, F32]
    displacement_error: F32
    stress_error: F32
    travel_error: F32
    von_mises_pa: F32 | None = None

    def __len__(self) -> int:
        return len(self.grasp)

    def __repr__(self) -> str:
        return f"Predictions({len(self)} grasps, {len(self.failed)} failed, {len(self.force_n)} loads)"


def predict(
    scene: str | os.PathLike[str],
    object: str | None = None,
    *,
    model: str | os.PathLike[str] | None = None,
    poses: npt.ArrayLike | None = None,
    force: float | None = None,
    frames: int | None = None,
    extrapolate: bool = False,
    threads: int | None = None,
) -> Predictions:
    """Predicts the grasps of a scene by a trained network, all at once, like `tactus predict`.

    object: name, for scenes with several.
    model: folder of a trained network; None is that of the scene, else the one that ships, `"universe"`.
    poses: (G, 7), px py pz qw qx qy qz of the hand in the object frame, in place of the scene's grasps.
    force: final force of a squeeze, the sum over the fingers, N.
    frames: number of loads.
    extrapolate: answers outside the range of the training, too.
    threads: number; all of the machine if None.

    ValueError for what is refused; FileNotFoundError, or another OSError, for a file that the operating system refuses.
    """
    arrays, pads, surface, failed, notices = _tactus.predict(
        os.fspath(scene),
        object,
        None if model is None else os.fspath(model),
        None if poses is None else np.atleast_2d(np.asarray(poses, dtype=np.float64)),
        force,
        frames,
        extrapolate,
        threads,
    )
    # As single precision the numbers of grasps are exact.
    grasp = arrays.pop("grasp").astype(np.int64)
    # The pads have it.
    arrays.pop("rest_m")
    meshes = tuple(Pad(**pad) for pad in pads)
    for notice in notices:
        logging.getLogger("tactus").warning("%s", notice)
    return Predictions(
        grasp=grasp, failed=failed, notices=tuple(notices), pads=meshes, object=Surface(**surface), **arrays
    )
