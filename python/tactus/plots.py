"""Pictures of grasps, drawn with Matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .meshes import F64, Pad

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def faces(pads: tuple[Pad, ...], displacement_m: F64, contact_force_n: F64 | None, title: str) -> Figure:
    """Draws the sensing face of each pad: magnitude of the displacement, and below it the pressure if forces are given.

    displacement_m, contact_force_n: (P, n, 3), m and N. The faces are viewed from outside.
    Raises ValueError without pads.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise ImportError("this needs matplotlib, which is not installed: pip install matplotlib") from error

    if not pads:
        raise ValueError("a grasp without pads has no sensing face to draw")
    rows: list[tuple[str, str, list[F64], list[Any]]] = []
    moved = [1e3 * np.linalg.norm(displacement, axis=1) for displacement in displacement_m]
    rows.append(("displacement, mm", "viridis", moved, [pad.sensing for pad in pads]))
    if contact_force_n is not None:
        pressure = [1e-3 * pad.pressure(force) for pad, force in zip(pads, contact_force_n)]
        rows.append(("pressure, kPa", "inferno", pressure, [pad.face() for pad in pads]))
    figure = Figure(figsize=(4.0 * len(pads) + 0.8, 3.6 * len(rows)), layout="constrained")
    axes = figure.subplots(len(rows), len(pads), squeeze=False)
    for row, (name, colours, values, triangles) in zip(axes, rows):
        shown = [np.nan_to_num(value) for value in values]
        most = max(float(value[corners].max()) for value, corners in zip(shown, triangles))
        for side, (axis, pad, value, corners) in enumerate(zip(row, pads, shown, triangles)):
            x, y = 1e3 * pad.rest_m[:, 0], 1e3 * pad.rest_m[:, 1]
            drawn = axis.tripcolor(x, y, corners, value, shading="gouraud", cmap=colours, vmin=0.0, vmax=most or 1.0)
            axis.set(aspect="equal", title=_name(side), xlabel="x, mm", ylabel="y, mm")
        figure.colorbar(drawn, ax=row, label=name)
    figure.suptitle(title)
    return figure


def _name(side: int) -> str:
    return ("left", "right")[side] if side < 2 else f"pad {side}"
