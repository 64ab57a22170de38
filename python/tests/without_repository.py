"""The installed package finds its network, tasks and backends without the repository. Run by `tests/python.sh`."""

import importlib.metadata
import importlib.util
from pathlib import Path

import gymnasium
import numpy as np

import tactus
from tactus import ron

package = Path(tactus.__file__).parent
assert package.parent.name == "site-packages" and not list(Path.cwd().iterdir()), package
assert not any(importlib.util.find_spec(name) for name in ("pytest", "torch", "matplotlib")), "the environment is bare"
assert (package / "py.typed").exists() and importlib.metadata.version("tactus")

scene = tactus.scene(
    object={"shape": ron.Sphere(radius=0.02)},
    gripper={"pads": ron.GelSightMini(), "material": ron.Preset("gelsight_mini"), "opening": 0.08},
    loading=ron.Squeeze(force=5.0, frames=2),
)
many = tactus.predict(scene)
assert many.failed == {} and np.abs(many.displacement_m).max() > 1e-4
solved, predicted = (tactus.run(scene, backend=backend)[0] for backend in ("condensed", "gnn"))
assert solved.status == predicted.status == "reached"
# The network's travel has an error of a few per cent: `docs/results.md`.
assert np.allclose(solved.travel_m, predicted.travel_m, rtol=0.25)

for name in ("Hold", "Squeeze", "Regrasp"):
    env = gymnasium.make_vec(f"tactus/{name}-v0", num_envs=2, objects=["sphere"])
    obs, _ = env.reset(seed=1)
    assert env.observation_space.contains(obs)
    assert np.isfinite(env.step(env.action_space.sample())[1]).all()

assert tactus.check(scene).good
print("the wheel runs without the repository:", package)
