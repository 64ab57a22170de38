"""The other commands of the command line, run in this process; each returns its report as data.

Arguments are the options of the command, None selects the default; `tactus COMMAND --help` lists all options. Messages
of a command are sent to the logger `tactus`. Raises ValueError with file, line and column for invalid input, and
FileNotFoundError or another OSError for a file error of the operating system. After Ctrl-C finished work is kept.
"""

from __future__ import annotations

import json
import os
import socket
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Callable, Iterable, Mapping, Sequence, Union

from . import _tactus

Path = Union[str, "os.PathLike[str]"]
Told = Callable[[int, int], object]


@dataclass(frozen=True)
class Report:
    """Report of a command.

    good: True if the command succeeded (exit code 0).
    data: output of the command with `--format json`.
    """

    good: bool
    data: dict[str, Any]

    def __getitem__(self, key: str) -> Any:
        return self.data[key]


def command(*arguments: Path, progress: Told | None = None) -> tuple[int, str]:
    """Runs any command, e.g. `tactus.command("predict", "scene.ron", "-o", "out")`; returns its exit code and printed
    report."""
    return _tactus.command([os.fspath(argument) for argument in arguments], True, progress)


def check(scene: Path, *, object: str | None = None, export: Path | None = None) -> Report:
    """Checks a scene and reports what would be run.

    export: output file for the object surface (`.obj`, `.stl`) or the grasps (`.h5`).
    """
    return _report(["check"], [scene], dict(object=object, export=export))


def dataset(
    scene: Path,
    out: Path,
    *,
    objects: Sequence[str] | None = None,
    grasps: int | None = None,
    frames: int | None = None,
    seed: int | None = None,
    worst_of: Path | None = None,
    keep: int | None = None,
    max_time: float | None = None,
    part: tuple[int, int] | None = None,
    sensitivity: int | None = None,
    dry_run: bool = False,
    threads: int | None = None,
    progress: Told | None = None,
) -> Report:
    """Simulates all grasps of all objects of a scene into a data set; an interrupted command is resumed.

    grasps: number of grasps per object, taken from the beginning.
    part: (I, N): part I of N, from 1 to N.
    progress: function called with (finished frames, total).
    """
    options = dict(
        out=out,
        object=objects,
        grasps=grasps,
        frames=frames,
        seed=seed,
        worst_of=worst_of,
        keep=keep,
        max_time=max_time,
        part=None if part is None else f"{part[0]}/{part[1]}",
        sensitivity=sensitivity,
        dry_run=dry_run,
        threads=threads,
    )
    return _report(["dataset"], [scene], options, progress)


def inspect(
    folder: Path, *, pictures: Path | None = None, every: int | None = None, frames: int | None = None
) -> Report:
    """Returns counts, ranges and histograms of a data set; `good` if no data is damaged."""
    return _report(["dataset", "inspect"], [folder], dict(pictures=pictures, every=every, frames=frames))


def train(
    data: Path | Sequence[Path],
    model: Path,
    out: Path,
    *,
    split: str | None = None,
    threads: int | None = None,
    progress: Told | None = None,
) -> Report:
    """Trains a network on data sets; an interrupted command is resumed.

    model: model specification file, RON.
    progress: function called with (finished epochs, total).
    """
    options = dict(model=model, out=out, split=split, threads=threads)
    return _report(["train"], _several(data), options, progress)


def eval(
    data: Path,
    model: Path,
    *,
    split: str | None = None,
    extrapolate: bool = False,
    pictures: Path | None = None,
    worst: int | None = None,
    dump: Path | None = None,
    threads: int | None = None,
) -> Report:
    """Evaluates a network on the test grasps of a data set."""
    options = dict(
        model=model, split=split, extrapolate=extrapolate, pictures=pictures, worst=worst, dump=dump, threads=threads
    )
    return _report(["eval"], [data], options)


def bench(
    scene: Path,
    *,
    object: str | None = None,
    grasps: int | None = None,
    frames: int | None = None,
    models: Path | Sequence[Path] = (),
    repeat: int | None = None,
    rungs: int | None = None,
    certify: bool = False,
    sizes: Sequence[int] | None = None,
    envs: Sequence[int] | None = None,
    out: Path | None = None,
    threads: int | None = None,
) -> Report:
    """Measures time against error of all settings.

    certify: True to compute reference values with their errors instead.
    sizes: measure cost against problem size instead.
    envs: measure the steps of a task with these numbers of environments instead.
    """
    options = dict(
        object=object,
        grasps=grasps,
        frames=frames,
        model=_several(models),
        repeat=repeat,
        rungs=rungs,
        certify=certify,
        sizes=_commas(sizes),
        envs=_commas(envs),
        out=out,
        threads=threads,
    )
    return _report(["bench"], [scene], options)


def fit(
    scene: Path,
    curve: Path,
    *,
    object: str | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    out: Path | None = None,
    threads: int | None = None,
) -> Report:
    """Fits Young's modulus, Poisson's ratio, friction and the depth offset of a press to a measured curve.

    curve: CSV with the header `depth_m,force_n`.
    ranges: (low, high) of `young`, `poisson`, `friction` or `depth_zero`.

    The report is good if every fit converged.
    """
    bounds = [f"{name}={low},{high}" for name, (low, high) in (ranges or {}).items()]
    return _report(["fit"], [scene], dict(curve=curve, object=object, range=bounds, out=out, threads=threads))


def report(
    folders: Path | Sequence[Path],
    out: Path,
    *,
    model: Path | None = None,
    split: str | None = None,
    grasps: int | None = None,
    frames: int | None = None,
) -> Report:
    """Writes an HTML page of runs, data sets, trainings and benchmarks to the file `out`."""
    options = dict(out=out, model=model, split=split, grasps=grasps, frames=frames)
    return _report(["report"], _several(folders), options)


def view(path: Path, *, model: Path | None = None, port: int | None = None, browser: bool = True) -> None:
    """Shows a folder of results, or runs a scene and shows it, in the browser until Ctrl-C; prints the address of the
    page.

    model: folder of a trained model to evaluate on a data set.
    port: port on 127.0.0.1; None selects a free port.
    browser: True to open the page.
    """
    if port is None:
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
    print(f"http://127.0.0.1:{port}/", flush=True)
    options = [f"--port={port}", *(["--open"] if browser else []), *([f"--model={os.fspath(model)}"] if model else [])]
    with suppress(KeyboardInterrupt):
        _tactus.command(["view", *options, "--", os.fspath(path)], False, None)


def _report(name: list[str], paths: Sequence[Path], options: Mapping[str, Any], progress: Told | None = None) -> Report:
    arguments = [*name, "--format=json"]
    for option, value in options.items():
        flag = "--" + option.replace("_", "-")
        if value is True:
            arguments.append(flag)
        elif value is not None and value is not False:
            values: Iterable[Any] = value if isinstance(value, (list, tuple)) else [value]
            arguments += [f"{flag}={os.fspath(v) if isinstance(v, os.PathLike) else v}" for v in values]
    code, text = _tactus.command([*arguments, "--", *(os.fspath(path) for path in paths)], False, progress)
    return Report(code == 0, json.loads(text) if text else {})


def _several(paths: Path | Sequence[Path]) -> list[Path]:
    return [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)


def _commas(numbers: Sequence[int] | None) -> str | None:
    return None if numbers is None else ",".join(map(str, numbers))
