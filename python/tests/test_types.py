"""The package and a program that uses it pass mypy."""

from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1]

PROGRAM = '''"""A program of a user."""

import numpy as np

import tactus
from tactus import ron


def told(done: int, of: int) -> None:
    print(done, of)


scene = tactus.scene(object={"shape": ron.Sphere(radius=0.02)}, loading=ron.Squeeze(force=5.0))
run = tactus.run(scene, backend="condensed", frames=2, grasps=[0], progress=told)
for grasp in run:
    deepest: float = float(np.linalg.norm(grasp.displacement_m, axis=-1).max())
    if grasp.contact_force_n is not None:
        print(grasp.status, deepest, grasp.contact_force_n.sum(axis=2), grasp.pads[0].tets.shape)
    grasp.plot().savefig("grasp.png")
many = tactus.predict("scene.ron", poses=np.zeros((1, 7)))
print(many.displacement_m.dtype, many.failed.get(0, ""))
data = tactus.DataSet("out", "train")
print(len(data), data[0]["force_n"].max(), [stored["object"] for stored in data])
print(tactus.check(scene).good, tactus.train(["a", "b"], "m.ron", "model")["epochs"])
env = tactus.VectorEnv(scene, 4, seed=1)
obs, infos = env.reset(seed=1)
obs, reward, terminated, truncated, infos = env.step(env.action_space.sample())
'''

WRONG = '''import tactus

tactus.run("scene.ron", backend="gpu")
tactus.run("scene.ron").grasps[0].colour
tactus.DataSet("out", "some")
'''


@pytest.fixture(scope="module")
def mypy(tmp_path_factory):
    api = pytest.importorskip("mypy.api")
    # A common cache, so that NumPy and others are analysed once for all tests.
    settings = ["--config-file", str(PACKAGE / "pyproject.toml"), "--cache-dir", str(tmp_path_factory.mktemp("mypy"))]
    return lambda *arguments: api.run([*settings, *map(str, arguments)])


def test_the_package_is_typed(mypy, monkeypatch):
    monkeypatch.chdir(PACKAGE)
    out, errors, code = mypy("-p", "tactus")
    assert code == 0, out + errors


def test_the_compiled_half_is_as_its_stub_says(monkeypatch, tmp_path):
    stubtest = pytest.importorskip("mypy.stubtest")
    # Outside the sources, so that the stub of the installed package is used.
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["stubtest", "tactus._tactus"])
    assert stubtest.main() == 0, "the captured output says where they differ"


def test_a_program_is_typed(mypy, monkeypatch, tmp_path):
    monkeypatch.setenv("MYPYPATH", str(PACKAGE))
    (tmp_path / "program.py").write_text(PROGRAM)
    out, errors, code = mypy(tmp_path / "program.py")
    assert code == 0, out + errors
    (tmp_path / "wrong.py").write_text(WRONG)
    out, errors, code = mypy(tmp_path / "wrong.py")
    assert code == 1 and out.count("error:") == 3, out + errors
