"""Meshes of pads and objects, and their conversion to other packages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Mapping

import numpy as np
import numpy.typing as npt

F32 = npt.NDArray[np.float32]
F64 = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

Library = Literal["trimesh", "pyvista", "meshio"]

# End corners of the edges of a tetrahedron, in the order of the mid-edge nodes.
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))


@dataclass(frozen=True, eq=False, repr=False)
class Pad:
    """Reference mesh of a pad, and its pose in the hand.

    Pad frame: origin at the centre of the sensing face, +z out of the gel, x along the approach. `n` nodes, `t`
    tetrahedra.

    rest_m: (n, 3), m, reference positions of the nodes in the pad frame; corners first.
    tets: (t, 4 or 10), nodes of each tetrahedron: corners, then midpoints of (0,1) (1,2) (2,0) (0,3) (1,3) (2,3).
    surface: (k, 3), corner triangles of the outer surface, oriented outwards.
    sensing: (k, 3), triangles of the sensing face, including mid-edge nodes, oriented outwards.
    bonded: (n), bool, True if the node is bonded to the finger.
    pad_pose: (7), m and 1, pose in the hand frame at zero travel: px py pz qw qx qy qz.
    closing: (3), closing direction of the finger, hand axes.
    """

    rest_m: F64
    tets: Indices
    surface: Indices
    sensing: Indices
    bonded: npt.NDArray[np.bool_]
    pad_pose: F64
    closing: F64

    def __repr__(self) -> str:
        return f"Pad({len(self.rest_m)} nodes, {len(self.tets)} tetrahedra)"

    def face(self) -> Indices:
        """Returns the triangles of the sensing face between corner nodes only: (k, 3)."""
        on_face = np.zeros(len(self.rest_m), np.bool_)
        on_face[self.sensing] = True
        face: Indices = self.surface[on_face[self.surface].all(axis=1)]
        return face

    def pressure(self, force_n: F64) -> F64:
        """Returns the pressure at the corner nodes of the sensing face, Pa: (n), NaN elsewhere.

        force_n: (n, 3), N, contact force on the nodes, hand axes. The force on a mid-edge node is split equally between
          the ends of its edge, and the area of a corner is a third of that of its triangles.
        """
        # The outward normal of the face is the closing direction, so pressure acts in the opposite direction.
        load = -force_n @ self.closing
        gathered = load.copy()
        if self.tets.shape[1] == 10:
            corners = self.tets[:, EDGES].reshape(-1, 2)
            middles, first = np.unique(self.tets[:, 4:].reshape(-1), return_index=True)
            np.add.at(gathered, corners[first].reshape(-1), np.repeat(load[middles] / 2, 2))
        face = self.face()
        a, b, c = (self.rest_m[face[:, k]] for k in range(3))
        area = np.zeros(len(self.rest_m))
        np.add.at(area, face.reshape(-1), np.repeat(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6, 3))
        pressure: F64 = np.divide(gathered, area, out=np.full(len(area), np.nan), where=area > 0)
        return pressure


@dataclass(frozen=True, eq=False, repr=False)
class Surface:
    """Surface of an object in the object frame.

    vertices_m: (k, 3), m, vertices.
    triangles: (k, 3), vertices of each triangle, oriented outwards.
    """

    vertices_m: F64
    triangles: Indices

    def __repr__(self) -> str:
        return f"Surface({len(self.vertices_m)} vertices, {len(self.triangles)} triangles)"


def rotate(quaternion: npt.ArrayLike, vectors: F64) -> F64:
    """Rotates vectors (..., 3) by a unit quaternion w x y z."""
    w, axis = np.asarray(quaternion, np.float64)[0], np.asarray(quaternion, np.float64)[1:]
    across = 2.0 * np.cross(axis, vectors)
    turned: F64 = vectors + w * across + np.cross(axis, across)
    return turned


def triangles_of(points: F64, triangles: Indices, values: Mapping[str, F64], library: Library) -> Any:
    """Returns a triangle mesh of `library` with points (k, 3), m, and point data."""
    if library == "trimesh":
        package = _package("trimesh")
        return package.Trimesh(points, triangles, vertex_attributes=dict(values), process=False)
    return _cells(points, triangles, "triangle", values, library)


def tetrahedra_of(points: F64, pad: Pad, values: Mapping[str, F64], library: Library) -> Any:
    """Returns a pad as a mesh of `library` with nodal data: its tetrahedra, or in trimesh its surface only."""
    if library == "trimesh":
        return triangles_of(points, pad.surface, values, library)
    return _cells(points, pad.tets, "tetra" if pad.tets.shape[1] == 4 else "tetra10", values, library)


def _cells(points: F64, cells: Indices, kind: str, values: Mapping[str, F64], library: Library) -> Any:
    if library == "meshio":
        return _package("meshio").Mesh(points, [(kind, cells)], point_data=dict(values))
    if library == "pyvista":
        package = _package("pyvista")
        # VTK cell types.
        number = {"triangle": 5, "tetra": 10, "tetra10": 24}[kind]
        grid = package.UnstructuredGrid({number: cells}, points)
        for name, value in values.items():
            grid.point_data[name] = value
        return grid
    raise ValueError(f'library {library!r}; allowed: "trimesh", "pyvista", "meshio"')


def _package(name: str) -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise ImportError(f"this needs {name}, which is not installed: pip install {name}") from error
