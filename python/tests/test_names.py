"""The arrays returned to Python have the documented names and shapes."""

import dataclasses
from pathlib import Path

import numpy as np

import tactus

ROOT = Path(__file__).parents[2]
STILL = """Scene(
    object: (shape: Sphere(radius: 0.02)),
    gripper: (pads: GelSightMini(spacing: 8e-3)),
    loading: Squeeze(force: 2.0, frames: 2),
    record: (fields: [Displacement, Stress, ContactForce, Gap, ObjectPose]),
)"""
MOVING = """Scene(
    object: (shape: Sphere(radius: 0.02)),
    gripper: (pads: GelSightMini(spacing: 8e-3)),
    gravity: (0, 0, -9.81),
    loading: Dynamic(motions: [Close(force: 2.0, duration: 0.02)], time_step: 2e-3, frames: 1),
    record: (fields: [Displacement, Stress, ContactForce, Gap, ObjectPose]),
)"""


def documented(place: str) -> dict[str, str]:
    """Returns the documented shapes in `tactus.run` that begin with `place`, without this prefix, by name."""
    text = (ROOT / "docs" / "data-format.md").read_text().split("\n## Arrays")[1].split("\n## ")[0]
    rows = [line.split("|") for line in text.replace("\\|", "").splitlines() if line.startswith("| `")]
    shapes = {row[1].strip(" `"): row[5].strip() for row in rows}
    return {name: shape.removeprefix(place) for name, shape in shapes.items() if shape.startswith(place)}


def assert_documented(value, shapes: dict[str, str], sizes: dict[str, int]) -> None:
    arrays = {f.name: a for f in dataclasses.fields(value) if isinstance(a := getattr(value, f.name), np.ndarray)}
    assert set(arrays) == set(shapes)
    for name, shape in shapes.items():
        wanted = [sizes.get(n.strip(), n.strip()) for n in shape.strip("()* ").split(",")]
        assert len(wanted) == arrays[name].ndim, name
        # These sizes depend on the mesh and are not stored elsewhere.
        free = ("k", "4 or 10")
        assert all(w in free or int(w) == n for w, n in zip(wanted, arrays[name].shape)), name


def test_a_run_gives_the_documented_arrays():
    shapes = documented("(")
    for scene, frames in ((STILL, 2), (MOVING, 1)):
        (grasp,) = tactus.run(tactus.Scene.from_ron(scene))
        pad = grasp.pads[0]
        sizes = {"F": frames, "P": 2, "n": len(pad.rest_m), "t": len(pad.tets)}
        own = {name: shape for name, shape in shapes.items() if scene is MOVING or not shape.endswith("*")}
        assert_documented(grasp, own, sizes)
        assert_documented(pad, documented("pad "), sizes)
        assert_documented(grasp.object, documented("object "), sizes)
