"""The arrays that Python gives have the names and shapes of the documentation."""

from pathlib import Path

import numpy as np

import tactus

ROOT = Path(__file__).parents[2]


def documented() -> dict[str, str]:
    """Shape in `tactus.run` by name."""
    text = (ROOT / "docs" / "data-format.md").read_text().split("\n## Arrays")[1].split("\n## ")[0]
    rows = [line.split("|") for line in text.replace("\\|", "").splitlines() if line.startswith("| `")]
    return {row[1].strip(" `"): row[5].strip() for row in rows if row[5].strip()}


def test_a_run_gives_the_documented_arrays(tmp_path):
    path = tmp_path / "scene.ron"
    path.write_text(
        "(object: (shape: Sphere(radius: 0.02)), gripper: (pads: GelSightMini(spacing: 8e-3)),"
        " loading: Squeeze(force: 2.0, frames: 2))"
    )
    (grasp,) = tactus.run(path)
    shapes = documented()
    arrays = {name: value for name, value in grasp.items() if isinstance(value, np.ndarray)}
    assert set(arrays) == set(shapes)
    frames, pads, nodes, _ = grasp["position_m"].shape
    sizes = {"F": frames, "P": pads, "n": nodes}
    for name, shape in shapes.items():
        expected = tuple(int(sizes.get(n.strip(), n)) for n in shape.strip("()").split(","))
        assert arrays[name].shape == expected, name
