"""Predictions of many grasps."""

from pathlib import Path

import numpy as np
import pytest

import tactus

SCENES = Path(__file__).parents[2] / "scenes"


def test_many_grasps_are_predicted_as_they_are_run():
    scene = tactus.load(SCENES / "lemon.ron")
    many = tactus.predict(scene)
    alone = tactus.run(scene, model="universe")
    assert many.grasp.tolist() == [0, 1] and many.failed == {} and len(many) == 2
    for answer, run in zip(many.travel_m, alone):
        assert np.allclose(answer, run.travel_m, rtol=1e-3)
    pressed = np.abs(many.contact_force_n.sum(axis=3)[..., 2])
    assert np.allclose(pressed, many.force_n[None, :, None] / 2, rtol=1e-4)
    assert (many.displacement_error > 0).all() and many.slip_margin.tolist() == [1, 1]
    assert np.array_equal(many.pads[0].rest_m, alone.pads[0].rest_m), "the same mesh"
    assert np.array_equal(many.object.vertices_m, alone.object.vertices_m)


def test_predictions_say_which_objects_slip(tmp_path):
    text = (SCENES / "lemon.ron").read_text().replace('"common/', f'"{(SCENES / "common").as_posix()}/')
    text = text.replace("Squeeze(", "Squeeze(push: (force: (0, 0, FORCE), frames: 2), ", 1)
    margins = []
    for force in (1.0, 100.0):
        path = tmp_path / f"{force}.ron"
        path.write_text(text.replace("FORCE", str(force)))
        margins.append(tactus.predict(path, extrapolate=True).slip_margin)
    assert (margins[0] > 0).all() and (margins[1] < 0).all()


def test_predictions_at_given_poses_say_which_grasps_fail():
    poses = [[0, 0, -0.1, 1, 0, 0, 0], [0, 0, 10, 1, 0, 0, 0]]
    many = tactus.predict(SCENES / "lemon.ron", poses=poses, force=10.0, frames=3)
    assert many.grasp.tolist() == [0] and many.displacement_m.shape[:2] == (1, 3)
    assert many.force_n[-1] == 10.0
    assert list(many.failed) == [1]
    with pytest.raises(ValueError, match="7 finite numbers"):
        tactus.predict(SCENES / "lemon.ron", poses=[[0, 0, 0]])


def test_sensors_of_predictions_see_what_those_of_runs_see(tmp_path):
    grid = "(rows: 6, cols: 5)"
    images = ", ".join(f"{name}{grid}" for name in ("TaxelForce", "TaxelDisplacement", "Pressure", "Shear", "HeightMap", "DepthMap", "Slip"))
    text = (SCENES / "lemon.ron").read_text().replace('"common/', f'"{(SCENES / "common").as_posix()}/')
    text = text.replace("Squeeze(", "Squeeze(push: (force: (0, 0, 8), frames: 2), ", 1)
    closing = text.rindex(")")
    (tmp_path / "scene.ron").write_text(
        f"{text[:closing]}record: (tactile: [{images}, Markers(rows: 3, cols: 2), CenterOfPressure, ContactArea]),\n)"
    )
    scene = tactus.load(tmp_path / "scene.ron")
    many = tactus.predict(scene, frames=3)
    alone = tactus.run(scene, backend="gnn", frames=3)
    assert len(many.tactile) == 10 and set(many.tactile) == set(alone[0].tactile)
    for name, seen in many.tactile.items():
        assert seen.shape[:3] == (len(many), 5, 2) and seen.any(), name
        assert all(np.array_equal(own, run.tactile[name]) for own, run in zip(seen, alone)), name
    assert tactus.predict(SCENES / "lemon.ron", frames=2).tactile == {}
