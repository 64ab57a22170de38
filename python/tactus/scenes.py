"""Scenes: files that were checked, or Python objects that become one."""

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
    """A checked scene file; it goes wherever the path of a scene goes.

    path: the file.
    objects: names of its objects.
    """

    path: str
    objects: tuple[str, ...]

    def ron(self, object: str | None = None) -> str:
        """The scene of one object as RON with every default written out; None is the only object."""
        return _tactus.resolved(self.path, object)

    def __fspath__(self) -> str:
        return self.path

    @classmethod
    def from_ron(cls, text: str, path: str | os.PathLike[str] | None = None) -> Scene:
        """Writes the text of a scene to `path` and loads it.

        Paths in the text start at the folder of `path`. Without `path` the file lies in a folder of this process that is gone at
        its end, and paths in the text have to be absolute. ValueError with file, line, column and what is allowed.
        """
        file = Path(path) if path is not None else Path(tempfile.mkdtemp(dir=_own_folder())) / "scene.ron"
        file.write_text(text, encoding="utf-8")
        return load(file)


def load(path: str | os.PathLike[str]) -> Scene:
    """Loads and checks a scene file.

    ValueError with file, line, column and what is allowed if it is wrong; FileNotFoundError, or another OSError, if it cannot be read.
    """
    path = os.fspath(path)
    return Scene(path, tuple(_tactus.objects(path)))


def scene(*, path: str | os.PathLike[str] | None = None, **fields: ron.Value) -> Scene:
    """Makes a scene of Python objects and loads it; `path` as in `Scene.from_ron`.

    The fields are those of a scene file: dictionaries for what stands in parentheses with names, tuples for vectors, lists,
    numbers, strings, None, `pathlib.Path` for files, and `tactus.ron.NAME` or `tactus.ron.NAME(...)` for one of several
    choices, like `tactus.ron.Sphere(radius=0.02)`.
    """
    # A line each, which a message about a mistake shows.
    lines = "".join(f"    {name}: {ron.text(value)},\n" for name, value in fields.items())
    return Scene.from_ron(f"Scene(\n{lines})\n", path)


_folder: str | None = None


def _own_folder() -> str:
    """The folder for scenes of this process."""
    global _folder
    if _folder is None:
        _folder = tempfile.mkdtemp(prefix="tactus-")
        atexit.register(_remove, _folder, os.getpid())
    return _folder


def _remove(folder: str, process: int) -> None:
    # A forked process leaves it to its parent.
    if os.getpid() == process:
        shutil.rmtree(folder, ignore_errors=True)
