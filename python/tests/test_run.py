"""Scenes run from Python, with the overrides of the command line."""

import dataclasses
import errno
import json
import logging
import os
import pickle
from pathlib import Path

import numpy as np
import pytest

import tactus

SCENES = Path(__file__).parents[2] / "scenes"
HOLD = SCENES / "tasks" / "hold.ron"
SMALL = """Scene(
    object: (shape: Sphere(radius: 0.02)),
    grasps: Antipodal(count: 3, seed: 1),
    gripper: (pads: GelSightMini(spacing: 8.0e-3)),
    loading: Squeeze(force: 5.0, frames: 4),
    expect: [ReachesForce],
)"""


@pytest.fixture(scope="module")
def small():
    return tactus.Scene.from_ron(SMALL)


def test_a_scene_runs_and_forces_balance():
    scene = tactus.load(HOLD)
    assert scene.objects[0] == "sphere" and "Antipodal" in scene.ron("sphere")
    run = tactus.run(scene, object="sphere")
    assert [g.status for g in run] == ["reached"] * 2 and len(run) == 2 and run.backend.startswith("fem")
    for grasp in run:
        pressed = np.abs(grasp.contact_force_n.sum(axis=2)[..., 0])
        assert np.allclose(pressed, grasp.force_n[:, None] / 2, rtol=1e-3)


def test_rest_meshes_are_those_of_the_nodes(small):
    grasp = tactus.run(small, grasps=[0])[0]
    for side, pad in enumerate(grasp.pads):
        n = len(pad.rest_m)
        assert pad.tets.shape[1] == 10 and pad.tets.max() == n - 1
        assert pad.surface.max() < n and pad.sensing.max() < n and np.abs(pad.rest_m[pad.sensing][..., 2]).max() < 1e-12
        # A node's position is its reference position in the hand plus the travel of the finger plus its displacement.
        w, axis = pad.pad_pose[3], pad.pad_pose[4:]
        across = 2 * np.cross(axis, pad.rest_m)
        at_rest = pad.rest_m + w * across + np.cross(axis, across) + pad.pad_pose[:3]
        carried = grasp.position_m[-1, side] - grasp.displacement_m[-1, side] - at_rest
        assert np.allclose(carried, carried[0], atol=1e-12) and np.allclose(carried[0], pad.closing * (carried[0] @ pad.closing))
        assert np.abs(grasp.displacement_m[:, side, pad.bonded]).max() == 0.0
        # The integral of the pressure at the corners is the force of the finger.
        pressure = pad.pressure(grasp.contact_force_n[-1, side])
        a, b, c = (pad.rest_m[pad.face()[:, k]] for k in range(3))
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        force = (area * pressure[pad.face()].mean(axis=1)).sum()
        assert abs(force / (grasp.force_n[-1] / 2) - 1) < 1e-3, "within 0.1 %"


def test_overrides_are_those_of_the_command_line(small, tmp_path):
    run = tactus.run(small, backend="condensed", force=3.0, frames=2, grasps=[2, 0], threads=1, out=tmp_path / "run")
    assert [g.number for g in run] == [2, 0] and run.threads == 1 and "condensed" in run.backend
    assert all(np.allclose(g.force_n, [1.5, 3.0], rtol=1e-3) for g in run), "N, at equal steps"
    assert run.good and [e.name for e in run.expectations] == ["ReachesForce"] and run.expectations[0].held
    assert (tmp_path / "run" / "grasp_002" / "arrays.npz").exists()
    code, text = tactus.command(
        "run", small, "--backend=condensed", "--force=3", "--frames=2", "--grasp=0", "--threads=1", "-o", tmp_path / "other"
    )
    assert code == 0 and "condensed" in text
    stored = np.load(tmp_path / "other" / "grasp_000" / "arrays.npz")
    nodes = run[0].position_m.shape[1:3]
    assert np.array_equal(stored["position_m"].reshape(2, *nodes, 3), run[1].position_m), "bit for bit"
    with pytest.raises(ValueError, match="earlier run"):
        tactus.run(small, grasps=[0], frames=1, out=tmp_path / "run")
    tactus.run(small, grasps=[0], frames=1, out=tmp_path / "run", overwrite=True, pictures=False)
    assert not (tmp_path / "run" / "grasp_000" / "pads.png").exists()


def test_grasps_come_in_the_order_asked_for_each_once(small, tmp_path):
    alone = [tactus.run(small, grasps=[k], frames=1)[0] for k in range(3)]
    run = tactus.run(small, grasps=[2, 0, 2, 1], frames=1, threads=2, out=tmp_path / "run", pictures=False, sensitivity=True)
    assert [g.number for g in run] == [g["grasp"] for g in run.report["grasps"]] == [2, 0, 1]
    assert [g["grasp"] for g in json.loads((tmp_path / "run" / "run.json").read_text())["grasps"]] == [2, 0, 1]
    for grasp in run:
        other = alone[grasp.number]
        assert np.array_equal(grasp.position_m, other.position_m) and np.array_equal(grasp.grasp_pose, other.grasp_pose)
        assert grasp.summary["sensitivity"], "every grasp has its own"
    # The sensitivity of a grasp does not depend on its position in the list.
    moved = lambda g: [change["displacement"] for change in g.summary["sensitivity"]]  # noqa: E731
    assert moved(tactus.run(small, grasps=[1], frames=1, sensitivity=True)[0]) == moved(run[2])
    assert run[:2] == run.grasps[:2]
    code, text = tactus.command("run", small, "--grasp=2", "--grasp=0", "--frames=1", "--format=json")
    assert code == 0 and [g["grasp"] for g in json.loads(text)["grasps"]] == [2, 0]


def test_a_network_runs_and_hands_over(small):
    lemon = SCENES / "lemon.ron"
    sure = tactus.run(lemon, backend="gnn", grasps=[0], frames=2)[0]
    assert sure.displacement_error.shape == (2,) and sure.handed_over is None
    unsure = tactus.run(lemon, model="universe", error_at_most=1e-6, grasps=[0], frames=2)[0]
    assert unsure.handed_over and unsure.displacement_error is None


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"backend": "gpu"}, 'allowed: "fem", "condensed", "gnn"'),
        ({"force": -1.0}, r"^error: force must be above zero, found -1"),
        ({"frames": 0}, r"^error: frames "),
        ({"grasps": [7]}, r"^error: grasp 7: the scene has 3 grasps, 0 to 2"),
        ({"grasps": []}, "at least one"),
        ({"error_at_most": 0.1}, r"error_at_most and extrapolate are allowed only for a network; add backend gnn"),
        ({"backend": "fem", "model": "universe"}, "model is allowed only for a network"),
        ({"max_time": 0.0}, r"^error: max_time "),
        ({"threads": 0}, r"^error: threads "),
    ],
)
def test_what_is_refused_is_named_as_in_python(small, settings, message):
    with pytest.raises(ValueError, match=message):
        tactus.run(small, **settings)


def test_progress_counts_grasps(small):
    told = []
    tactus.run(small, frames=1, progress=lambda *news: told.append(news))
    assert told[-1] == (3, 3) and told == sorted(set(told)), told


def test_notices_are_logged(tmp_path, caplog):
    text = SMALL.replace("expect:", "stepper: Fem(element: Linear), expect:")
    with caplog.at_level(logging.WARNING, logger="tactus"):
        run = tactus.run(tactus.Scene.from_ron(text), frames=1, grasps=[0])
    assert run.notices and list(run.notices) == [r.getMessage() for r in caplog.records if r.name == "tactus"]


def test_results_are_frozen_and_pickle(small):
    run = tactus.run(small, frames=1, grasps=[1], sensitivity=True)
    with pytest.raises(dataclasses.FrozenInstanceError):
        run[0].status = "fault"
    again = pickle.loads(pickle.dumps(run))
    assert np.array_equal(again[0].position_m, run[0].position_m) and repr(again) == repr(run)
    assert {m["change"] for m in run[0].summary["sensitivity"]} >= {"friction", "turn", "shift"}


def test_a_grasp_that_cannot_start_has_no_frames():
    far = SMALL.replace("Antipodal(count: 3, seed: 1)", "List([(position: (0, 0, 10))])")
    run = tactus.run(tactus.Scene.from_ron(far))
    assert run[0].status == "infeasible" and run[0].reason and not run.good
    assert run[0].position_m.shape == (0, 2, len(run.pads[0].rest_m), 3)
    with pytest.raises(IndexError, match="frame -1"):
        run[0].plot()


def test_a_mistake_is_reported_with_its_place(tmp_path):
    path = tmp_path / "bad.ron"
    path.write_text("(object: (shape: Sphere(radius: -1)), loading: Squeeze(force: 1))")
    with pytest.raises(ValueError, match=r"bad.ron:1:\d+"):
        tactus.load(path)


def test_a_file_that_the_system_refuses_is_an_error_of_the_system(tmp_path, small, monkeypatch):
    monkeypatch.chdir(tmp_path)
    asked = (
        tactus.load,
        tactus.run,
        tactus.predict,
        tactus.check,
        tactus.VectorEnv,
        lambda path: tactus.command("run", path),
        lambda path: tactus.dataset(path, "out"),
    )
    for ask in asked:
        with pytest.raises(FileNotFoundError, match="cannot be opened: no such file") as refused:
            ask("none.ron")
        assert refused.value.errno == errno.ENOENT and str(refused.value.filename) == "none.ron"
    with pytest.raises(IsADirectoryError, match="is a directory, not a scene file"):
        tactus.load(tmp_path)
    (tmp_path / "file").write_text("")
    for ask in (lambda: tactus.load("file/scene.ron"), lambda: tactus.run(small, frames=1, grasps=[0], out="file/run")):
        with pytest.raises(NotADirectoryError):
            ask()
    with pytest.raises(FileNotFoundError, match="a model is created by"):
        tactus.run(small, model="nowhere")
    with pytest.raises(FileNotFoundError, match="contains no data set"):
        tactus.DataSet("nowhere")
    # A missing file named in a scene is reported as an error of the scene.
    mesh = tmp_path / "mesh.ron"
    mesh.write_text('(object: (shape: Mesh("none.stl")), loading: Squeeze(force: 1))')
    with pytest.raises(ValueError, match=r"mesh.ron:1:\d+"):
        tactus.run(mesh)
    if os.geteuid():
        mesh.chmod(0)
        with pytest.raises(PermissionError):
            tactus.load(mesh)


def test_messages_are_verbatim_but_for_the_names_of_arguments(small, tmp_path):
    with pytest.raises(OSError, match="`tactus train DATASET --model M.ron -o nowhere`"):
        tactus.run(small, model="nowhere")
    scene = tmp_path / "a --max-time.ron"
    scene.write_text("(object: (shape: Sphere(radius: -1)), loading: Squeeze(force: 1)) // run with --max-time 5")
    with pytest.raises(ValueError, match="// run with --max-time 5") as refused:
        tactus.load(scene)
    assert f"{scene}:1:" in str(refused.value)
    with pytest.raises(ValueError, match="^error: error_at_most and extrapolate are allowed only for a network; add backend gnn"):
        tactus.run(small, error_at_most=0.1)
    # Errors of typed command lines name the options.
    for typed in ("--error-at-most=0.1", "--force=-1", "--threads=0"):
        with pytest.raises(ValueError, match=typed.split("=")[0]):
            tactus.command("run", small, typed)


def test_what_tactile_sensors_see_comes_by_name(tmp_path):
    images = "record: (tactile: [Pressure(rows: 6, cols: 5), ContactArea])"
    scene = tactus.Scene.from_ron(SMALL.replace("expect:", f"{images}, expect:"))
    grasp = tactus.run(scene, grasps=[0])[0]
    assert set(grasp.tactile) == {"pressure_pa", "contact_area_m2"}
    assert grasp.tactile["pressure_pa"].shape == (4, 2, 6, 5) and grasp.tactile["contact_area_m2"].shape == (4, 2)
    tactus.dataset(scene, tmp_path / "set", grasps=1)
    stored = tactus.DataSet(tmp_path / "set", "all")[0]["tactile"]
    assert set(stored) == set(grasp.tactile)
    assert all(np.array_equal(stored[name], grasp.tactile[name]) for name in stored)
    assert tactus.run(SCENES / "quickstart.ron", frames=1)[0].tactile == {}
