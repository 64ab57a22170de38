"""tactus: a parallel gripper with two soft visual-tactile pads squeezes a rigid object.

Everything is SI: m, N, Pa, kg; quaternions are (w, x, y, z). The tasks that ship with it are `tactus/Hold-v0`,
`tactus/Squeeze-v0` and `tactus/Regrasp-v0` of `gymnasium.make`.
"""

from . import shards
from ._tactus import DataSet
from .env import Env, VectorEnv
from .registry import register
from .scene import Scene, load, predict, run

__all__ = ["DataSet", "Env", "Scene", "VectorEnv", "load", "predict", "run", "shards"]

register()
