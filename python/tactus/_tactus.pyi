import os
from typing import Any, Callable, Sequence, final

import numpy as np
import numpy.typing as npt

_F32 = npt.NDArray[np.float32]

__all__ = [
    "SHIPPED",
    "Batch",
    "FaceInputs",
    "Files",
    "command",
    "face_weights",
    "make",
    "objects",
    "predict",
    "resolved",
    "run",
]

SHIPPED: tuple[str, ...]

@final
class Batch:
    def __new__(
        cls,
        scene: str,
        num_envs: int,
        seed: int,
        autoreset: str,
        max_steps: int | None,
        threads: int | None,
        objects: Sequence[str] | None,
        first_env: int,
        model: str | None,
    ) -> Batch: ...
    def observation_spec(self) -> list[tuple[str, list[int], str, float, float]]: ...
    def action_size(self) -> int: ...
    def reset(
        self,
        seed: int | None,
        seeds: Sequence[int | None] | None,
        mask: Sequence[bool] | None,
        out: Sequence[_F32],
    ) -> None: ...
    def step(
        self,
        actions: _F32,
        out: Sequence[_F32],
        reward: _F32,
        terminated: npt.NDArray[np.bool_],
        truncated: npt.NDArray[np.bool_],
    ) -> None: ...
    def final_obs(self, out: Sequence[_F32]) -> None: ...
    def info(self) -> list[tuple[bool, float, float, float, float, float, float]]: ...
    def faults(self) -> list[str | None]: ...
    def held_objects(self) -> list[str | None]: ...
    def seeds(self) -> list[int]: ...
    def begun(self) -> list[bool]: ...
    def save(self, env: int) -> bytes: ...
    def restore(self, env: int, snapshot: bytes, out: Sequence[_F32]) -> None: ...
    def render(self, env: int) -> npt.NDArray[np.uint8]: ...

@final
class Files:
    def __new__(cls, folder: str | os.PathLike[str]) -> Files: ...
    def damaged(self) -> list[str]: ...
    def objects(self) -> list[tuple[str, int, list[int]]]: ...
    def split(self, test: bool) -> list[tuple[str, int]]: ...
    def grasp(self, object: str, grasp: int) -> dict[str, npt.NDArray[Any]]: ...
    def pads(self, object: str) -> list[dict[str, Any]]: ...
    def surface(self, object: str) -> dict[str, Any]: ...
    def scene(self, object: str) -> str: ...

def command(arguments: list[str], typed: bool, progress: Callable[[int, int], object] | None) -> tuple[int, str]: ...
@final
class FaceInputs:
    def __new__(
        cls, scene: str, object: str | None, model: str, frames: int | None, extrapolate: bool, threads: int
    ) -> FaceInputs: ...
    def usual(self) -> dict[str, Any]: ...
    def pad(self) -> dict[str, npt.NDArray[Any]]: ...
    def grasps(
        self,
        poses: npt.NDArray[np.float64],
        force: npt.NDArray[np.float64],
        friction: npt.NDArray[np.float64],
        changes: Sequence[int],
    ) -> tuple[dict[str, _F32], dict[str, _F32], list[int], dict[int, str]]: ...

def face_weights(model: str) -> bytes: ...
def make(
    scene: str | os.PathLike[str], out: str | os.PathLike[str], part: tuple[int, int] | None, threads: int
) -> int: ...
def predict(
    scene: str,
    object: str | None,
    model: str | None,
    poses: npt.NDArray[np.float64] | None,
    force: float | None,
    frames: int | None,
    extrapolate: bool,
    threads: int | None,
) -> tuple[dict[str, Any], list[dict[str, Any]], dict[str, Any], dict[int, str], list[str]]: ...
def objects(scene: str) -> list[str]: ...
def resolved(scene: str, object: str | None) -> str: ...
def run(
    scene: str,
    object: str | None,
    backend: str | None,
    model: str | None,
    force: float | None,
    frames: int | None,
    grasps: list[int],
    error_at_most: float | None,
    extrapolate: bool,
    threads: int | None,
    max_time: float | None,
    sensitivity: bool,
    out: str | None,
    overwrite: bool,
    pictures: bool,
    progress: Callable[[int, int], object] | None,
) -> tuple[str, bool, list[str], float, list[dict[str, Any]], dict[str, Any], list[dict[str, Any]]]: ...
