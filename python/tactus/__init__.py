"""tactus: a parallel gripper with two soft visual-tactile pads squeezes a rigid object.

All quantities are in SI units: m, N, Pa, kg; quaternions are (w, x, y, z). The included tasks for `gymnasium.make` are
`tactus/Hold-v0`, `tactus/Squeeze-v0` and `tactus/Regrasp-v0`. Warnings are sent to the logger `tactus`.
"""

from . import ron, shards
from .commands import Report, bench, check, command, dataset, eval, fit, inspect, report, train, view
from .data import DataSet, StoredGrasp
from .env import Env, VectorEnv
from .meshes import Pad, Surface
from .prediction import Predictions, predict
from .registry import register
from .scenes import Scene, load, scene
from .simulation import Expectation, Grasp, Run, run

__all__ = [
    "DataSet",
    "Env",
    "Expectation",
    "Grasp",
    "Pad",
    "Predictions",
    "Report",
    "Run",
    "Scene",
    "StoredGrasp",
    "Surface",
    "VectorEnv",
    "bench",
    "check",
    "command",
    "dataset",
    "eval",
    "fit",
    "inspect",
    "load",
    "predict",
    "report",
    "ron",
    "run",
    "scene",
    "shards",
    "train",
    "view",
]

register()
