"""Plots and meshes of grasps, for packages that are installed."""

import builtins
import importlib

import numpy as np
import pytest

import tactus

SCENE = """Scene(
    object: (shape: Sphere(radius: 0.02)),
    gripper: (pads: GelSightMini(spacing: 4.0e-3)),
    loading: Squeeze(force: 5.0, frames: 2),
)"""


@pytest.fixture(scope="module")
def grasp():
    return tactus.run(tactus.Scene.from_ron(SCENE))[0]


def test_a_picture_shows_displacement_and_pressure_of_both_faces(grasp, tmp_path):
    pytest.importorskip("matplotlib")
    figure = grasp.plot(frame=0)
    assert [a.get_title() for a in figure.axes[:4]] == ["left", "right"] * 2
    assert [a.get_ylabel() for a in figure.axes[4:]] == ["displacement, mm", "pressure, kPa"]
    figure.savefig(tmp_path / "grasp.png")
    (moved,) = [c for c in figure.axes[0].collections]
    largest = 1e3 * np.linalg.norm(grasp.displacement_m[0, :, grasp.pads[0].sensing.ravel()], axis=-1).max()
    assert moved.get_clim() == (0.0, pytest.approx(largest, rel=1e-12))
    with pytest.raises(IndexError, match="frame 2 of grasp 0, which has 2"):
        grasp.plot(frame=2)


def test_trimesh_has_closed_surfaces_that_touch(grasp):
    pytest.importorskip("trimesh")
    pad, ball = grasp.pad_mesh(0), grasp.object_mesh()
    assert pad.is_watertight and ball.is_watertight
    assert abs(ball.volume / (4 / 3 * np.pi * 0.02**3) - 1) < 0.01, "a ball of 20 mm, within 1 %"
    assert np.allclose(ball.center_mass, grasp.object_pose[-1, :3], atol=1e-5), "m"
    distance = np.linalg.norm(pad.vertices - grasp.object_pose[-1, :3], axis=1) - 0.02
    assert -5e-5 < distance.min() < 5e-5, "the pad lies on the ball, within 50 micrometres"
    assert pad.vertex_attributes["contact_force_n"].shape == pad.vertices.shape


@pytest.mark.parametrize("library", ["meshio", "pyvista"])
def test_others_have_the_tetrahedra(grasp, library):
    pytest.importorskip(library)
    mesh = grasp.pad_mesh(1, frame=0, library=library)
    assert np.array_equal(mesh.points, grasp.position_m[0, 1])
    fields = mesh.point_data
    assert np.array_equal(fields["von_mises_pa"], grasp.von_mises_pa[0, 1])
    cells = mesh.cells[0].data if library == "meshio" else mesh.cells_dict[24]
    assert np.array_equal(cells, grasp.pads[1].tets)


def test_what_is_not_installed_is_named(grasp, monkeypatch):
    real = builtins.__import__

    def without(name, *rest):
        if name.split(".")[0] in ("matplotlib", "pyvista"):
            raise ImportError(name)
        return real(name, *rest)

    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr(builtins, "__import__", without)
    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(ImportError, match="needs matplotlib, which is not installed: pip install matplotlib"):
        grasp.plot()
    with pytest.raises(ImportError, match="needs pyvista, which is not installed"):
        grasp.object_mesh(library="pyvista")
    with pytest.raises(ValueError, match='allowed: "trimesh", "pyvista", "meshio"'):
        grasp.object_mesh(library="blender")
