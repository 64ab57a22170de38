"""Your own mesh: squeezed, drawn, predicted, and how far the prediction is off. Usage: first_squeeze.py MESH"""
import sys
from pathlib import Path

import numpy as np

import tactus
from tactus import ron

scene = tactus.scene(
    object={"shape": ron.Mesh(Path(sys.argv[1]))},
    gripper={"pads": ron.GelSightMini(), "opening": 0.08},
    grasps=ron.Antipodal(count=3, seed=1),
    loading=ron.Squeeze(force=10.0, frames=5),
)
for truth, fast in zip(tactus.run(scene, backend="condensed"), tactus.run(scene, backend="gnn")):
    off = np.linalg.norm(fast.displacement_m[-1] - truth.displacement_m[-1]) / np.linalg.norm(truth.displacement_m[-1])
    print(f"grasp {truth.number}: {truth.wall_s / fast.wall_s:.0f} times as fast, {off:.1%} off", end="; ")
    print(f"it says at most {fast.displacement_error[-1]:.1%}")
    truth.plot().savefig(f"grasp_{truth.number}.png")
