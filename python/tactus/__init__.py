"""tactus: a parallel gripper with two soft visual-tactile pads squeezes a rigid object.

Everything is SI: m, N, Pa, kg; quaternions are (w, x, y, z).
"""

from ._tactus import DataSet
from .env import Env, VectorEnv
from .scene import Scene, load, run

__all__ = ["DataSet", "Env", "Scene", "VectorEnv", "load", "run"]
