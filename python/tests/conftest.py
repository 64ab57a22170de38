"""Small data set and network shared by all tests, and the signal handler that tests require."""

import signal
from pathlib import Path
from typing import NamedTuple

import pytest

import tactus

# A shell without job control starts background processes with SIGINT ignored, which Python and its children inherit.
signal.signal(signal.SIGINT, signal.default_int_handler)

SMALL = """Scene(
    object: (shape: Sphere(radius: 0.02)),
    grasps: Antipodal(count: 6, seed: 1),
    gripper: (pads: GelSightMini(spacing: 8.0e-3)),
    loading: Squeeze(force: 5.0, frames: 3),
)"""
TWO = """Scene(
    objects: [
        (name: "ball", object: (shape: Sphere(radius: 0.02))),
        (name: "box", object: (shape: Cuboid(size: (0.03, 0.03, 0.03)))),
    ],
    grasps: Antipodal(count: 5, seed: 1),
    gripper: (pads: GelSightMini(spacing: 8.0e-3)),
    loading: Squeeze(force: 5.0, frames: 3),
)"""
MODEL = """Model(
    network: Face(latent: 8, rounds: 2, decoder: 8, depths: 3),
    training: (epochs: 3, batch: 2, levels: 2, frames: 2, validation: 0.3, seed: 3),
)"""


class Made(NamedTuple):
    """Output folder of a command, its report, and all calls of its progress function."""

    folder: Path
    report: tactus.Report
    told: list[tuple[int, ...]]


@pytest.fixture(scope="session")
def small():
    """Returns a scene of a ball with six grasps of three frames."""
    return tactus.Scene.from_ron(SMALL)


@pytest.fixture(scope="session")
def two():
    """Returns a scene of two objects with five grasps of three frames each."""
    return tactus.Scene.from_ron(TWO)


@pytest.fixture(scope="session")
def data_set(two, tmp_path_factory):
    """Generates the data set of two objects."""
    folder, told = tmp_path_factory.mktemp("data") / "set", []
    report = tactus.dataset(two, folder, progress=lambda *news: told.append(news))
    return Made(folder, report, told)


@pytest.fixture(scope="session")
def trained(data_set, tmp_path_factory):
    """Trains a network on the data set."""
    folder, told = tmp_path_factory.mktemp("model"), []
    (folder / "tiny.ron").write_text(MODEL)
    progress = lambda *news: told.append(news)  # noqa: E731
    report = tactus.train(data_set.folder, folder / "tiny.ron", folder / "model", progress=progress)
    return Made(folder / "model", report, told)
