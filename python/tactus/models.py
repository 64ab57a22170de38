"""Trained networks, by folder or by name."""

from __future__ import annotations

import os

from . import _tactus


def lasting(model: str | os.PathLike[str]) -> str:
    """The model for use from another working directory: a folder by its absolute path, one that ships by its name."""
    return os.fspath(model) if os.fspath(model) in _tactus.SHIPPED else os.path.abspath(model)
