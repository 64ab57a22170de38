"""Scenes and data sets from Python."""

from pathlib import Path

import numpy as np
import pytest

import tactus

SCENES = Path(__file__).parents[2] / "scenes"


def test_a_scene_runs_and_forces_balance():
    scene = tactus.load(SCENES / "tasks" / "hold.ron")
    assert scene.objects[0] == "sphere" and "Antipodal" in scene.ron("sphere")
    grasps = tactus.run(scene, object="sphere")
    assert [g["status"] for g in grasps] == ["reached"] * 2
    for grasp in grasps:
        pressed = np.abs(grasp["contact_force_n"].sum(axis=2)[..., 0])
        assert np.allclose(pressed, grasp["force_n"][:, None] / 2, rtol=1e-3)


def test_a_mistake_is_reported_with_its_place(tmp_path):
    path = tmp_path / "bad.ron"
    path.write_text("(object: (shape: Sphere(radius: -1)), loading: Squeeze(force: 1))")
    with pytest.raises(ValueError, match=r"bad.ron:1:\d+"):
        tactus.load(path)
