"""Scenes: checked scene files, or scene files generated from Python objects."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from . import _tactus, ron


@dataclass(frozen=True)
class Scene:
    """Checked scene file; can be used in place of the path of a scene.

    path: path of the file.
    objects: names of its objects.
    """

    path: str
    objects: tuple[str, ...]

    def ron(self, object: str | None = None) -> str:
        """Returns the scene of one object as RON with all defaults written out; None selects the only object."""
        return _tactus.resolved(self.path, object)

    def __fspath__(self) -> str:
        return self.path

    @classmethod
    def from_ron(cls, text: str, path: str | os.PathLike[str] | None = None) -> Scene:
        """Writes the text of a scene to `path` and loads it.

        Paths in the text are relative to the folder of `path`. Without `path` the file is written to a temporary
        folder, which is removed when the process ends, and paths in the text must be absolute. Raises ValueError with
        file, line, column and the allowed values.
        """
        file = Path(path) if path is not None else Path(tempfile.mkdtemp(dir=_own_folder())) / "scene.ron"
        file.write_text(text, encoding="utf-8")
        return load(file)


def load(path: str | os.PathLike[str]) -> Scene:
    """Loads and checks a scene file.

    Raises ValueError with file, line, column and the allowed values if it is invalid, and FileNotFoundError or another
    OSError if it cannot be read.
    """
    path = os.fspath(path)
    return Scene(path, tuple(_tactus.objects(path)))


def scene(*, path: str | os.PathLike[str] | None = None, **fields: ron.Value) -> Scene:
    """Creates a scene from Python objects and loads it; `path` as in `Scene.from_ron`.

    The fields are those of a scene file: dictionaries for structs, tuples for vectors, lists, numbers, strings, None,
    `pathlib.Path` for files, and `tactus.ron.NAME` or `tactus.ron.NAME(...)` for enum variants, e.g.
    `tactus.ron.Sphere(radius=0.02)`.
    """
    # One line per field, because error messages quote the line.
    lines = "".join(f"    {name}: {ron.text(value)},\n" for name, value in fields.items())
    return Scene.from_ron(f"Scene(\n{lines})\n", path)


_folder: str | None = None


def _own_folder() -> str:
    """Returns the temporary folder for scenes of this process."""
    global _folder
    if _folder is None:
        _folder = tempfile.mkdtemp(prefix="tactus-")
        atexit.register(_remove, _folder, os.getpid())
    return _folder


def _remove(folder: str, process: int) -> None:
    # In a forked process the folder belongs to the parent.
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)
