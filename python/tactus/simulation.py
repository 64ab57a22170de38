"""Simulated grasps: `tactus.run` and its result."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Iterator, Literal, Sequence, overload

from . import _tactus, plots
from .meshes import F32, F64, Library, Pad, Surface, rotate, tetrahedra_of, triangles_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Backend = Literal["fem", "condensed", "gnn"]
Status = Literal["reached", "dropped", "fault", "infeasible"]


@dataclass(frozen=True, eq=False, repr=False)
class Grasp:
    """Simulated grasp, in the hand frame: origin at the hand base, +z along the approach, fingers close along x.

    `F` frames up to the end of the grasp, all valid; `P` pads, left first; `n` nodes and `t` tetrahedra per pad.

    number: index of the grasp in its scene, from 0.
    status: `reached`, `dropped` (the object left the grasp), `fault` (solver failure) or `infeasible` (it could not
      start).
    reason: reason why the load was not reached, or None.
    handed_over: reason why finite elements computed the grasp instead of the network, or None.
    wall_s: wall time, s.
    summary: its entry in `run.json`, with iterations, methods, smallest det F and gap, sensitivity.
    pads: reference meshes of the pads.
    object: surface of the object.
    grasp_pose: (7), m and 1, initial pose of the hand in the object frame: px py pz qw qx qy qz.
    force_n: (F), N, applied force: sum over the fingers of |normal force|.
    time_s: (F), s, time of a dynamic scene, otherwise zero.
    travel_m: (F, P), m, closing travel of each finger since first contact.
    object_pose: (F, 7), m and 1, pose of the object in the hand frame.
    object_load: (F, 6), N and N m, external load on the object (weight and applied push): force and torque about its
      centre of mass.
    wrench: (F, P, 6), N and N m, contact force and torque on each pad, about the origin of its pad frame.
    position_m: (F, P, n, 3), m, node positions.
    displacement_m: (F, P, n, 3), m, node displacements relative to the pad carried rigidly by its finger.
    tactile: arrays of the recorded tactile sensors by name: (F, P, ...), as listed in `docs/data-format.md`.

    The following are None if they are not recorded or do not apply:

    contact_force_n: (F, P, n, 3), N, nodal contact force on the pad, friction included.
    von_mises_pa: (F, P, n), Pa, per node.
    element_von_mises_pa: (F, P, t), Pa, per tetrahedron.
    gap_m: (F, P, n), m, signed distance of each node to the object, negative inside.
    displacement_error, stress_error, travel_error: (F), 90 % quantiles of the relative errors of a network; infinite if
      unknown.
    hand_pose: (F, 7), m and 1, pose of the hand in the world; of dynamic scenes only, like the next two.
    object_motion: (F, 6), m/s and rad/s, velocity of the centre of mass and angular velocity, world axes.
    ground_force_n: (F, 3), N, force of the ground on the object, world axes.
    """

    number: int
    status: Status
    reason: str | None
    handed_over: str | None
    wall_s: float
    summary: dict[str, Any]
    pads: tuple[Pad, ...]
    object: Surface
    grasp_pose: F64
    force_n: F64
    time_s: F64
    travel_m: F64
    object_pose: F64
    object_load: F64
    wrench: F64
    position_m: F64
    displacement_m: F64
    tactile: dict[str, F32]
    contact_force_n: F64 | None = None
    von_mises_pa: F64 | None = None
    element_von_mises_pa: F64 | None = None
    gap_m: F64 | None = None
    displacement_error: F64 | None = None
    stress_error: F64 | None = None
    travel_error: F64 | None = None
    hand_pose: F64 | None = None
    object_motion: F64 | None = None
    ground_force_n: F64 | None = None

    def __repr__(self) -> str:
        return f"Grasp({self.number}: {self.status}, {len(self.force_n)} frames, {len(self.pads)} pads)"

    def plot(self, frame: int = -1) -> Figure:
        """Draws the sensing faces of a frame with Matplotlib: displacement, and pressure if contact forces are
        recorded.

        Raises IndexError if the grasp has no such frame, ImportError without Matplotlib.
        """
        self._check(frame)
        force = None if self.contact_force_n is None else self.contact_force_n[frame]
        title = f"grasp {self.number}, {self.force_n[frame]:.3g} N, {self.status}"
        return plots.faces(self.pads, self.displacement_m[frame], force, title)

    def pad_mesh(self, pad: int, frame: int = -1, library: Library = "trimesh") -> Any:
        """Returns a deformed pad in the hand frame, m, with the recorded nodal fields: as tetrahedra in PyVista
        (`UnstructuredGrid`) and meshio (`Mesh`), as surface in trimesh (`Trimesh`).

        Raises IndexError if there is no such pad or frame, ImportError without the library.
        """
        self._check(frame)
        fields = ("displacement_m", "contact_force_n", "von_mises_pa", "gap_m")
        known = {name: getattr(self, name) for name in fields}
        values = {name: array[frame, pad] for name, array in known.items() if array is not None}
        return tetrahedra_of(self.position_m[frame, pad], self.pads[pad], values, library)

    def object_mesh(self, frame: int = -1, library: Library = "trimesh") -> Any:
        """Returns the surface of the object in the hand frame, m, as a mesh of trimesh, PyVista or meshio. Errors as
        `pad_mesh`."""
        self._check(frame)
        pose = self.object_pose[frame]
        points = pose[:3] + rotate(pose[3:], self.object.vertices_m)
        return triangles_of(points, self.object.triangles, {}, library)

    def _check(self, frame: int) -> None:
        if not -len(self.force_n) <= frame < len(self.force_n):
            raise IndexError(f"frame {frame} of grasp {self.number}, which has {len(self.force_n)}")


@dataclass(frozen=True)
class Expectation:
    """Expectation of the scene and its result.

    name: name as in the scene.
    held: True if it is met in every grasp.
    value: worst value; None without a frame.
    bound: bound for the value.
    """

    name: str
    held: bool
    value: float | None
    bound: float | None


@dataclass(frozen=True, eq=False, repr=False)
class Run:
    """Simulated grasps of a scene: a sequence of `Grasp`.

    grasps: grasps in the order of the scene, or in the requested order.
    good: True if all expectations of the scene are met; without expectations, if every grasp reached its load.
    expectations: expectations of the scene.
    backend: name of the backend with its settings.
    threads: number of threads.
    notices: warnings about the validity of the results, also logged.
    wall_s: total wall time, s.
    pads: reference meshes of the pads.
    object: surface of the object.
    report: content of `run.json`.
    """

    grasps: tuple[Grasp, ...]
    good: bool
    expectations: tuple[Expectation, ...]
    backend: str
    threads: int
    notices: tuple[str, ...]
    wall_s: float
    pads: tuple[Pad, ...]
    object: Surface
    report: dict[str, Any]

    def __len__(self) -> int:
        return len(self.grasps)

    @overload
    def __getitem__(self, index: int) -> Grasp: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Grasp, ...]: ...
    def __getitem__(self, index: int | slice) -> Grasp | tuple[Grasp, ...]:
        return self.grasps[index]

    def __iter__(self) -> Iterator[Grasp]:
        return iter(self.grasps)

    def __repr__(self) -> str:
        return f"Run({len(self)} grasps, {self.backend}, {'good' if self.good else 'not good'})"


def run(
    scene: str | os.PathLike[str],
    object: str | None = None,
    *,
    backend: Backend | None = None,
    model: str | os.PathLike[str] | None = None,
    force: float | None = None,
    frames: int | None = None,
    grasps: Sequence[int] | None = None,
    error_at_most: float | None = None,
    extrapolate: bool = False,
    threads: int | None = None,
    max_time: float | None = None,
    sensitivity: bool = False,
    out: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    pictures: bool = True,
    progress: Callable[[int, int], object] | None = None,
) -> Run:
    """Simulates grasps of a scene, like `tactus run`; None uses the value of the scene.

    object: name of the object, for scenes with several.
    backend: `"fem"`, `"condensed"` or `"gnn"`.
    model: folder of a trained network or name of the included one, `"universe"`; implies `"gnn"`.
    force: final force of a squeeze, sum over the fingers, N.
    frames: number of recorded frames.
    grasps: indices of the grasps to run, from 0, in this order, each once.
    error_at_most: largest predicted relative error of the displacement that is accepted from a network; finite elements
      compute the other grasps.
    extrapolate: True to use a network also outside of its training range.
    threads: number of threads; all of the machine unless the scene sets it.
    max_time: maximum wall time of a grasp, s.
    sensitivity: True to measure the effect of small changes of each grasp, stored in `Grasp.summary`, at five times the
      cost.
    out: folder for the files of a run.
    overwrite: True to replace an earlier run in `out`.
    pictures: True to draw `pads.png` of each grasp in `out`.
    progress: function called with (finished grasps, total).

    Raises ValueError with file, line and column for invalid input, FileNotFoundError or another OSError for a file
    error of the operating system, and KeyboardInterrupt within a second of Ctrl-C.
    """
    if grasps is not None and len(grasps) == 0:
        raise ValueError("grasps: at least one number is needed; None runs all")
    text, good, notices, wall_s, pads, surface, arrays = _tactus.run(
        os.fspath(scene),
        object,
        "gnn" if backend is None and model is not None else backend,
        None if model is None else os.fspath(model),
        force,
        frames,
        [] if grasps is None else list(grasps),
        error_at_most,
        extrapolate,
        threads,
        max_time,
        sensitivity,
        None if out is None else os.fspath(out),
        overwrite,
        pictures,
        progress,
    )
    report = json.loads(text)
    meshes, body = tuple(Pad(**pad) for pad in pads), Surface(**surface)
    return Run(
        grasps=tuple(_grasp(own, meshes, body, rows) for own, rows in zip(report["grasps"], arrays)),
        good=good,
        expectations=tuple(Expectation(**held) for held in report["expectations"]),
        backend=report["backend"],
        threads=report["threads"],
        notices=tuple(notices),
        wall_s=wall_s,
        pads=meshes,
        object=body,
        report=report,
    )


def _grasp(summary: dict[str, Any], pads: tuple[Pad, ...], object: Surface, arrays: dict[str, Any]) -> Grasp:
    return Grasp(
        number=summary["grasp"],
        status=summary["status"],
        reason=summary["reason"],
        handed_over=summary.get("handed_over"),
        wall_s=summary["wall_s"],
        summary=summary,
        pads=pads,
        object=object,
        **arrays,
    )
