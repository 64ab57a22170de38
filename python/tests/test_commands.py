"""Commands of the command line, called from Python."""

import logging
from pathlib import Path

import numpy as np
import pytest

import tactus

SCENES = Path(__file__).parents[2] / "scenes"
PRESS = """Scene(
    object: (shape: Sphere(radius: 0.02), motion: Fixed),
    gripper: (pads: GelSightMini(spacing: 8.0e-3), fingers: One),
    loading: Press(depth: 0.001, frames: 2),
)"""


def test_check_shows_what_would_run(small, tmp_path):
    report = tactus.check(small, export=tmp_path / "grasps.h5")
    assert report.good and report["grasps"] == 6 and report["problems"] == []
    assert report["pads"][0]["nodes"] > 100 and (tmp_path / "grasps.h5").exists()
    far = tactus.Scene.from_ron(Path(small.path).read_text().replace("Antipodal(count: 6, seed: 1)", "List([(position: (0, 0, 10))])"))
    refused = tactus.check(far)
    assert not refused.good and len(refused["problems"]) == 1
    with pytest.raises(ValueError, match="has no object \"cup\""):
        tactus.check(SCENES / "tasks" / "hold.ron", object="cup")


def test_a_data_set_is_made_in_parts(small, tmp_path):
    assert tactus.dataset(small, tmp_path, grasps=2, dry_run=True).data == {}
    assert tactus.dataset(small, tmp_path, grasps=2, part=(1, 2))["computed"] == 1
    assert tactus.dataset(small, tmp_path, grasps=2)["computed"] == 1


def test_a_network_is_trained_and_judged_and_reported(small, data_set, trained, tmp_path):
    assert trained.report.good and len(trained.report["curve"]) == trained.report["epochs"] == trained.told[-1][0]
    judged = tactus.eval(data_set.folder, trained.folder, worst=1)
    assert judged["grasps"] >= 1 and len(judged["worst"]) == 1
    tactus.run(small, grasps=[0], out=tmp_path / "run")
    page = tactus.report([tmp_path / "run", data_set.folder], tmp_path / "page.html", grasps=1)
    assert page["bytes"] == len((tmp_path / "page.html").read_bytes())


def test_bench_and_fit_measure(small, tmp_path):
    sizes = tactus.bench(small, sizes=[200, 300], repeat=1, threads=1, out=tmp_path / "bench")
    assert sizes.good and (tmp_path / "bench" / "sizes.json").exists()
    press = tactus.Scene.from_ron(PRESS)
    run = tactus.run(press)[0]
    rows = zip(run.travel_m[:, 0], run.force_n)
    (tmp_path / "curve.csv").write_text("depth_m,force_n\n" + "".join(f"{d},{f}\n" for d, f in rows))
    with pytest.raises(ValueError, match="range"):
        tactus.fit(press, tmp_path / "curve.csv", ranges={"colour": (0, 1)})


def test_wrong_arguments_are_named_as_in_python(small, tmp_path):
    with pytest.raises(ValueError, match=r"invalid value '0' for 'grasps") as refused:
        tactus.bench(small, grasps=0)
    assert "--" not in str(refused.value)
    with pytest.raises(ValueError, match="seed is allowed only for a scene with a universe"):
        tactus.dataset(small, tmp_path, seed=3)


def test_what_a_command_says_is_logged(small, tmp_path, caplog):
    with caplog.at_level(logging.INFO, logger="tactus"):
        tactus.dataset(small, tmp_path / "data", dry_run=True)
    assert "6 grasps of 3 frames" in caplog.text


def test_any_command_runs(small, tmp_path):
    code, text = tactus.command("predict", SCENES / "lemon.ron", "--grasps=1", "--frames=2", "-o", tmp_path)
    assert code == 0 and text.startswith("object lemon")
    assert np.load(tmp_path / "lemon.npz")["grasp"].tolist() == [0]
