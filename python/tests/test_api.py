"""`docs/python-api.md` is generated from the docstrings of the package.

`TACTUS_WRITE_DOCS=1 pytest python/tests/test_api.py` writes it again.
"""

import inspect
import os
import re
from pathlib import Path

import tactus
from tactus import commands, data, env, meshes, prediction, ron, scenes, shards, simulation

PAGE = Path(__file__).parents[2] / "docs" / "python-api.md"
MODULES = (scenes, ron, simulation, meshes, prediction, data, commands, env, shards)
HEAD = """# Python reference

Everything in `tactus`, made from the docstrings (`TACTUS_WRITE_DOCS=1 pytest python/tests/test_api.py` writes this page). Units are SI,
quaternions are (w, x, y, z). [python.md](python.md) shows how it is used.
"""


def signature(function) -> str:
    """Returns the arguments with types and defaults as written in the source."""
    shown, before = [], None
    for name, p in inspect.signature(function).parameters.items():
        if name in ("self", "cls"):
            continue
        if p.kind is p.KEYWORD_ONLY and before not in (p.KEYWORD_ONLY, p.VAR_POSITIONAL):
            shown.append("*")
        stars = {p.VAR_POSITIONAL: "*", p.VAR_KEYWORD: "**"}.get(p.kind, "")
        default = "" if p.default is p.empty else f" = {p.default!r}"
        shown.append(f"{stars}{name}: {p.annotation}{default}")
        before = p.kind
    # One argument per line if they do not fit on one line.
    line = ", ".join(shown)
    return f"({line})" if len(line) < 80 else "(\n    " + ",\n    ".join(shown) + ",\n)"


def returned(function) -> str:
    kind = inspect.signature(function).return_annotation
    return "" if kind in (None, "None", inspect.Signature.empty) else f" -> {kind}"


def paragraphs(item) -> str:
    return inspect.cleandoc(item.__doc__ or "")


def listed(text: str) -> str:
    """Returns the text with lines that begin with the name of a field turned into a list."""
    names = re.compile(r"^([a-z][a-z0-9_]*(?:, [a-z][a-z0-9_]*)*): ", re.M)
    return names.sub(lambda match: f"- `{match[1].replace(', ', '`, `')}`: ", text)


def of_function(name: str, function) -> str:
    return f"### `{name}`\n\n```python\n{name}{signature(function)}{returned(function)}\n```\n\n{listed(paragraphs(function))}\n"


def of_class(kind) -> str:
    text = f"### `{kind.__name__}`\n\n"
    if "__init__" in vars(kind) and not hasattr(kind, "__dataclass_fields__"):
        text += f"```python\n{kind.__name__}{signature(kind.__init__)}\n```\n\n"
    text += f"{listed(paragraphs(kind))}\n"
    for name, member in vars(kind).items():
        function = getattr(member, "__func__", member)
        if not name.startswith("_") and inspect.isfunction(function):
            about = listed(paragraphs(function)) or "As Gymnasium's."
            text += f"\n#### `{kind.__name__}.{name}`\n\n```python\n{name}{signature(function)}{returned(function)}\n```\n\n{about}\n"
    return text


def page() -> str:
    parts, seen = [HEAD], set()
    for module in MODULES:
        inside = module in (ron, shards)
        title, _, about = paragraphs(module).partition("\n\n")
        parts.append(f"## {title.rstrip('.')}\n" + (f"\n{about}\n" if about else ""))
        for name, item in vars(module).items():
            own = getattr(item, "__module__", None) == module.__name__ and not name.startswith("_")
            if not own or not (inside or name in tactus.__all__):
                continue
            seen.add(name)
            if inspect.isclass(item):
                parts.append(of_class(item))
            elif inspect.isfunction(item) and item.__doc__:
                parts.append(of_function(f"{module.__name__}.{name}" if inside else f"tactus.{name}", item))
    missing = set(tactus.__all__) - seen - {"ron", "shards"}
    assert not missing, f"{missing} are in no module of the reference"
    return "\n".join(parts)


def test_the_reference_is_that_of_the_docstrings():
    text = page()
    if os.environ.get("TACTUS_WRITE_DOCS"):
        PAGE.write_text(text)
    assert PAGE.read_text() == text, "TACTUS_WRITE_DOCS=1 pytest python/tests/test_api.py writes it anew"


def test_everything_says_what_it_is():
    for name in tactus.__all__:
        assert (getattr(tactus, name).__doc__ or "").strip(), name
