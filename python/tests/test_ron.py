"""Scenes built from Python objects."""

from pathlib import Path

import numpy as np
import pytest

import tactus
from tactus import ron

SCENES = Path(__file__).parents[2] / "scenes"


def lemon(**more):
    return tactus.scene(
        about='A "lemon" \\ two pads',
        object={"shape": ron.Lemon(length=0.06, diameter=0.044), "density": np.float64(950.0)},
        gripper={
            "pads": ron.GelSightMini(),
            "material": ron.Preset("gelsight_mini"),
            "opening": 0.08,
            "friction": 0.8,
            "fingers": ron.Both,
        },
        loading=ron.Squeeze(force=15.0, frames=np.int64(10), push={"force": (0.0, 0.0, 0.1), "frames": 2}),
        gravity=None,
        expect=[ron.ReachesForce, ron.NoInversion],
        **more,
    )


def test_a_scene_comes_back_as_it_was_written(tmp_path):
    whole = lemon().ron()
    assert 'about: "A \\"lemon\\" \\\\ two pads"' in whole and "force: 15" in whole and "density: 950" in whole
    again = tactus.Scene.from_ron(whole, tmp_path / "again.ron")
    assert again.ron() == whole and again.objects == ("again",)
    assert tactus.load(tmp_path / "again.ron") == again


def test_it_is_the_scene_of_the_same_text():
    text = """(about: "A \\"lemon\\" \\\\ two pads",
        object: (shape: Lemon(length: 0.06, diameter: 0.044), density: 950),
        gripper: (pads: GelSightMini(), material: Preset("gelsight_mini"), opening: 0.08, friction: 0.8),
        loading: Squeeze(force: 15, frames: 10, push: (force: (0, 0, 0.1), frames: 2)), expect: [ReachesForce, NoInversion])"""
    assert tactus.Scene.from_ron(text).ron() == lemon().ron()


def test_paths_are_those_of_python(tmp_path, monkeypatch):
    monkeypatch.chdir(SCENES)
    made = tactus.scene(include=[Path("common/gelsight_gripper.ron")], object={"shape": ron.Sphere(radius=0.02)}, loading=ron.Squeeze(force=1))
    monkeypatch.chdir(tmp_path)
    assert "Sphere" in made.ron() and tactus.run(made, frames=1, grasps=[0])[0].status == "reached"


def test_a_scene_goes_where_a_path_goes():
    scene = tactus.load(SCENES / "tasks" / "hold.ron")
    env = tactus.VectorEnv(scene, 2, objects=["sphere"])
    assert env.reset(seed=1)[0]["travel"].shape == (2, 2)


def test_what_is_wrong_is_named():
    with pytest.raises(ValueError, match=r"scene.ron:\d+:\d+(.|\n)*Spere(.|\n)*Sphere"):
        tactus.scene(object={"shape": ron.Spere(radius=0.02)}, loading=ron.Squeeze(force=1))
    with pytest.raises(ValueError, match="finite"):
        ron.text(float("nan"))
    with pytest.raises(TypeError, match="set in a scene"):
        ron.text({1, 2})
    with pytest.raises(ValueError, match="'a b' as a field"):
        ron.text({"a b": 1})
    with pytest.raises(ValueError, match="not both"):
        ron.Sphere(1, radius=2)
    with pytest.raises(AttributeError):
        ron.sphere
