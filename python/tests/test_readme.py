"""Every Python snippet of the README and of `docs/` runs, with smaller numbers and with files of the test."""

import ast
import re
import textwrap
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]

# Replacements of text in snippets.
STAND_INS = {
    '"scenes/': f'"{ROOT.as_posix()}/scenes/',
    ".ron\", 64": '.ron", 2',
    "num_envs=1024": "num_envs=2",
    "num_envs=64": "num_envs=2",
    "steps=100": "steps=2",
    "parts=64": "parts=2",
    '"out/small", grasps=4': '"out/small", grasps=1, frames=2',
}

SMALL = """Scene(
    object: (shape: Sphere(radius: 0.02)),
    grasps: Antipodal(count: 2, seed: 1),
    gripper: (pads: GelSightMini(spacing: 6.0e-3)),
    loading: Squeeze(force: 5.0, frames: 2),
)"""


# Packages required to import a module.
NEEDED = {
    "torch": ("torch", "safetensors"),
    "tactus.torch": ("torch", "safetensors"),
    "onnxruntime": ("onnx", "onnxscript", "onnxruntime"),
}


def blocks(text):
    """Returns the Python blocks of a Markdown text: fenced ones, and indented ones that use tactus or Gymnasium."""
    fenced = re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)
    without = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    indented = re.findall(r"(?:^ {4,}\S.*\n(?:[ \t]*\n(?= {4}))?)+", without, re.M)
    return fenced + [block for block in map(textwrap.dedent, indented) if is_python(block)]


def is_python(block):
    try:
        tree = ast.parse(block)
    except SyntaxError:
        return False
    names = [node.id for node in ast.walk(tree) if isinstance(node, ast.Name)]
    modules = [a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names]
    return "tactus" in names + modules or "gymnasium" in modules


def snippets():
    # The page of signatures is generated from the package.
    texts = [ROOT / "README.md", *sorted(set((ROOT / "docs").glob("**/*.md")) - {ROOT / "docs" / "python-api.md"})]
    found = [(path.name, block) for path in texts for block in blocks(path.read_text())]
    return [pytest.param(block, id=f"{name}-{k}") for k, (name, block) in enumerate(found)]


def test_there_is_something_to_run():
    assert len(snippets()) >= 2


@pytest.mark.parametrize("block", snippets())
def test_a_snippet_runs(block, tmp_path, monkeypatch):
    import tactus

    monkeypatch.chdir(tmp_path)
    for said, stands_in in STAND_INS.items():
        block = block.replace(said, stands_in)
    (tmp_path / "small.ron").write_text(SMALL)
    names = {
        "tactus": tactus,
        "scene": str(ROOT / "scenes" / "tasks" / "hold.ron"),
        "out": str(tmp_path / "out"),
        "obs": {"travel": np.zeros((2, 2), np.float32), "force": np.zeros((2, 1), np.float32)},
    }
    for statement in ast.parse(block).body:
        line = ast.unparse(statement)
        if "ray." in line or "cluster=True" in line:
            ray = pytest.importorskip("ray", reason="the rest of the snippet is for a Ray cluster, which is not installed")
            names["ray"] = ray
            line = line.replace("address='auto'", "")
        for package in NEEDED.get(line.removeprefix("import "), ()):
            pytest.importorskip(package, reason=f"the rest of the snippet needs {package}, which is not installed")
        if "shards.dataset(scene" in line:
            line = line.replace("scene, out", f"{str(tmp_path / 'small.ron')!r}, {str(tmp_path / 'set')!r}")
        try:
            exec(line, names)
        except ImportError as error:
            if "which is not installed" in str(error):
                pytest.skip(f"for the rest of the snippet: {error}")
            raise
