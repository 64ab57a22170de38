"""Predictions of a network for many grasps: `tactus.predict` and its result."""

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
    """Predictions of a network for the `G` successful grasps of a scene at `F` loads. `P` pads, left first, `n` nodes
    per pad.

    grasp: (G), indices of the grasps.
    failed: failure reasons of the other grasps, by index.
    notices: warnings about the validity of predictions, also logged: frames without a prediction, unknown errors.
    pads: reference meshes of the pads.
    object: surface of the object.
    force_n: (F), N, sum over the fingers of |normal force|.
    travel_m: (G, F, P), m, closing travel of each finger since first contact.
    object_pose: (G, F, 7), m and 1, pose of the object in the hand frame: px py pz qw qx qy qz.
    displacement_m: (G, F, P, n, 3), m, in the pad frames.
    contact_force_n: (G, F, P, n, 3), N, on the pad, in the pad frames.
    slip_margin: (G), smallest remaining fraction, over the loads, of the load at which the object slips: 1 without weight
      and push, negative if it slips.
    slip_margin_low, slip_margin_high: (G), ends of its 90 % interval; infinite if unknown.
    von_mises_pa: (G, F, P, n), Pa; None if the scene does not record it.
    displacement_error, stress_error, travel_error: (G, F), 90 % quantiles of the relative errors; infinite if unknown:
      outside of the training range, or for a network trained on few grasps.
    tactile: arrays of the recorded tactile sensors by name: (G, F, P, ...), as of a run.
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
    slip_margin_low: F32
    slip_margin_high: F32
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
    """Predicts the grasps of a scene with a trained network in one batch, like `tactus predict`.

    object: name of the object, for scenes with several.
    model: folder of a trained network; None uses that of the scene, or the included one, `"universe"`.
    poses: (G, 7), px py pz qw qx qy qz of the hand in the object frame; None uses the grasps of the scene.
    force: final force of a squeeze, sum over the fingers, N.
    frames: number of loads.
    extrapolate: True to predict also outside of the training range.
    threads: number of threads; None uses all of the machine.

    Raises ValueError for invalid input, and FileNotFoundError or another OSError for a file error of the operating
    system.
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
    # The indices are exact in single precision.
    grasp = arrays.pop("grasp").astype(np.int64)
    # Already contained in the pads.
    arrays.pop("rest_m")
    meshes = tuple(Pad(**pad) for pad in pads)
    for notice in notices:
        logging.getLogger("tactus").warning("%s", notice)
    return Predictions(
        grasp=grasp, failed=failed, notices=tuple(notices), pads=meshes, object=Surface(**surface), **arrays
    )
