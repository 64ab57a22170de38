"""Conversion of Python values to RON, the format of scene files.

`tactus.ron.NAME` is the enum variant of that name, `tactus.ron.NAME(...)` a variant with values:
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
    """Enum variant of a scene; a call adds its values, by position or by name.

    name: name as in the scene.
    held: RON text in parentheses; None without parentheses.
    """

    name: str
    held: str | None = None

    def __call__(self, *values: Value, **fields: Value) -> Variant:
        if values and fields:
            raise ValueError(f"{self.name}: values by position or by name, not both")
        inside = struct(fields) if fields else f"({', '.join(map(text, values))})"
        return Variant(self.name, inside)


def text(value: Value) -> str:
    """Returns a value as RON. Raises ValueError for non-finite numbers, TypeError for types that a scene cannot
    contain."""
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
    """Returns named fields in parentheses as RON."""
    for name in fields:
        if not (isinstance(name, str) and name.isidentifier()):
            raise ValueError(f"{name!r} as a field of a scene; allowed: names like `force`")
    return f"({', '.join(f'{name}: {text(value)}' for name, value in fields.items())})"


def __getattr__(name: str) -> Variant:
    # Names of variants are capitalised; any other name is an unknown attribute.
    if not name[:1].isupper():
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return Variant(name)
