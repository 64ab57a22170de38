"""Only `tactus.torch` requires PyTorch."""

import subprocess
import sys


def test_tactus_does_not_import_torch_and_says_what_to_install_where_it_is_missing():
    code = """
import sys
import tactus
assert "torch" not in sys.modules
sys.modules["torch"] = None
try:
    import tactus.torch
except ImportError as error:
    assert 'pip install "./python[torch]"' in str(error), error
else:
    raise AssertionError("there is no torch")
"""
    subprocess.run([sys.executable, "-c", code], check=True)
