"""The network in PyTorch and in ONNX Runtime beside the Rust engine."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import tactus

torch = pytest.importorskip("torch", reason="PyTorch is not installed")
pytest.importorskip("safetensors", reason="safetensors is not installed")

import tactus.torch  # noqa: E402

SCENES = Path(__file__).parents[2] / "scenes"
FIELDS = tactus.torch.Answer._fields[:3]
OBJECTS = tactus.load(SCENES / "paper.ron").objects


def off(mine, theirs):
    """The largest error of a grasp over its largest field: (G, ...) both."""
    mine, theirs = (np.asarray(x, dtype=np.float64).reshape(len(x), -1) for x in (mine, theirs))
    return (np.linalg.norm(mine - theirs, axis=1) / np.linalg.norm(theirs, axis=1)).max()


@pytest.fixture(scope="module")
def network():
    return tactus.torch.Network.load("universe")


@pytest.mark.parametrize("name", OBJECTS)
def test_fields_of_fifty_grasps_are_those_of_the_engine_within_1e_4(network, name):
    on = network.on(SCENES / "paper.ron", object=name, frames=3)
    poses = on.seen.usual()["poses"][:5]
    many = tactus.predict(SCENES / "paper.ron", object=name, poses=poses, frames=3)
    answer = on(poses)
    assert answer.grasp == many.grasp.tolist() and list(answer.failed) == list(many.failed)
    for field, mine in zip(FIELDS, answer):
        assert off(mine, getattr(many, field)) < 1e-4, field
