"""Names and folders of trained networks."""

from __future__ import annotations

import os

from . import _tactus


def lasting(model: str | os.PathLike[str]) -> str:
    """Returns a reference to a model that is valid in any working directory: its name if included, else its absolute
    path."""
    return os.fspath(model) if os.fspath(model) in _tactus.SHIPPED else os.path.abspath(model)
