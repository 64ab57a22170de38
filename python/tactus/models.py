"""Trained networks, by folder or by name."""

from __future__ import annotations

import os

from . import _tactus


def lasting(model: str | os.PathLike[str] | None) -> str | None:
    """The model for use from another working directory: a folder by its absolute path, one that ships by its name."""
    if model is None or os.fspath(model) in _tactus.SHIPPED:
        return None if model is None else os.fspath(model)
    return os.path.abspath(model)
