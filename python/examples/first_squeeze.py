"""Squeezes your own mesh, draws the result, and compares it with the prediction of the network."""
import argparse
from pathlib import Path

import numpy as np

import tactus
from tactus import ron

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("mesh", type=Path, help="closed surface in an OBJ, STL or PLY file")
parser.add_argument("--scale", type=float, default=1.0, help="factor from the file's unit to metres: 0.001 for millimetres")
given = parser.parse_args()
object, gripper = {"shape": ron.Mesh(given.mesh), "scale": given.scale}, {"pads": ron.GelSightMini(), "opening": 0.08}
scene = tactus.scene(object=object, gripper=gripper, grasps=ron.Antipodal(count=3, seed=1), loading=ron.Squeeze(force=10.0, frames=5))
for truth, fast in zip(tactus.run(scene, backend="condensed"), tactus.run(scene, backend="gnn")):
    off = np.linalg.norm(fast.displacement_m[-1] - truth.displacement_m[-1]) / np.linalg.norm(truth.displacement_m[-1])
    times, most = truth.wall_s / fast.wall_s, fast.displacement_error[-1]
    print(f"grasp {truth.number}: {times:.0f} times as fast, error {off:.1%}, error bound {most:.1%}")
    truth.plot().savefig(f"grasp_{truth.number}.png")
