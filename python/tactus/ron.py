"""Python values as RON, the notation of scene files.

`tactus.ron.NAME` is the choice of that name, `tactus.ron.NAME(...)` one that holds something:
`ron.Squeeze(force=15.0)`, `ron.Preset("gelsight_mini")`, `ron.Both`.
"""

from __future__ import annotations

import math
import numbers
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Union

Value = Union["Variant", Mapping[str, Any], Sequence[Any], str, "os.PathLike[str]", float, None]


@dataclass(frozen=True)
class Variant:
    """One of several choices of a scene; a call gives it what it holds, by position or by name.

    name: as in the scene.
    held: what stands in its parentheses, RON; None without parentheses.
    """

    name: str
    held: str | None = None

    def __call__(self, *values: Value, **fields: Value) -> Variant:
        if values and fields:
            raise ValueError(f"{self.name}: values by position or by name, not both")
        inside = struct(fields) if fields else f"({', '.join(map(text, values))})"
        return Variant(self.name, inside)


def text(value: Value) -> str:
    """A value as RON. ValueError for numbers that are not finite, TypeError for what a scene cannot hold."""
    match value:
        case None:
            return "None"
        case Variant(name, held):
            return name + (held or "")
        case bool():
            return "true" if value else "false"
        case str():
            escaped = value.replace("\\", "\\\\").replace('"', '\\"')
            return f'"{escaped}"'
        case os.PathLike():
            return text(os.path.abspath(value))
        case numbers.Integral():
            return str(int(value))
        case numbers.Real():
            if not math.isfinite(value):
                raise ValueError(f"{value} in a scene; allowed: finite numbers")
            return repr(float(value))
        case Mapping():
            return struct(value)
        case tuple():
            return f"({', '.join(map(text, value))})"
        case Sequence():
            return f"[{', '.join(map(text, value))}]"
    allowed = "numbers, strings, None, paths, dictionaries, tuples, lists, tactus.ron.NAME"
    raise TypeError(f"{type(value).__name__} in a scene; allowed: {allowed}")


def struct(fields: Mapping[str, Value]) -> str:
    """Fields in parentheses."""
    for name in fields:
        if not (isinstance(name, str) and name.isidentifier()):
            raise ValueError(f"{name!r} as a field of a scene; allowed: names like `force`")
    return f"({', '.join(f'{name}: {text(value)}' for name, value in fields.items())})"


def __getattr__(name: str) -> Variant:
    # Names of choices are written like this; all others are looked up by Python itself.
    if not name[:1].isupper():
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return Variant(name)
