"""A small data set and a small network, made once for all tests that need one; signals as tests need them."""

import signal
from pathlib import Path
from typing import NamedTuple

import pytest

import tactus

# A shell without job control starts what stands in its background with SIGINT ignored, and Python and its children leave it so.
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
    """Folder of what a command made, its report, and all that its progress told."""

    folder: Path
    report: tactus.Report
    told: list[tuple[int, ...]]


@pytest.fixture(scope="session")
def small():
    """A ball with six grasps of three frames."""
    return tactus.Scene.from_ron(SMALL)


@pytest.fixture(scope="session")
def two():
    """Two objects with five grasps of three frames each."""
    return tactus.Scene.from_ron(TWO)


@pytest.fixture(scope="session")
def data_set(two, tmp_path_factory):
    """The data set of two objects."""
    folder, told = tmp_path_factory.mktemp("data") / "set", []
    report = tactus.dataset(two, folder, progress=lambda *news: told.append(news))
    return Made(folder, report, told)


@pytest.fixture(scope="session")
def trained(data_set, tmp_path_factory):
    """A network trained on the data set."""
    folder, told = tmp_path_factory.mktemp("model"), []
    (folder / "tiny.ron").write_text(MODEL)
    progress = lambda *news: told.append(news)  # noqa: E731
    report = tactus.train(data_set.folder, folder / "tiny.ron", folder / "model", progress=progress)
    return Made(folder / "model", report, told)
