"""docs/api.md from the docstrings of the public names; a test checks that it is current.

python docs/api_page.py
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

PAGE = Path(__file__).resolve().parent / "api.md"
PACKAGES = ("bluekoi", "bluekoi.explain")
HEAD = """# Python interface

Made by `python docs/api_page.py` from the docstrings of the public names; edit those. The examples
run as tests. Other modules may change between versions. Units are SI and angles are radians,
counter-clockwise positive, unless the name says otherwise (`head_angle_deg`)."""


def page() -> str:
    """Text of docs/api.md."""
    found = [name for name in PACKAGES if find_spec(name)]
    return "\n".join([HEAD, *(line for name in found for line in _package(name))]) + "\n"


def _package(name: str) -> Iterator[str]:
    yield f"\n## `{name}`"
    package = import_module(name)
    for public in sorted(package.__all__, key=str.lower):
        yield from _entry(public, getattr(package, public))


def _entry(name: str, thing: Any) -> Iterator[str]:
    yield f"\n### `{name}`\n"
    if callable(thing):
        yield f"```python\n{_signature(name, thing)}\n```\n"
    yield as_markdown(inspect.getdoc(thing) or "")
    yield from _members(thing)


def _signature(name: str, thing: Any) -> str:
    """Name and arguments as they are written, long ones with a line for each argument."""
    kind = "class " if inspect.isclass(thing) else ""
    found = inspect.signature(thing)
    arguments = [_argument(one) for one in found.parameters.values()]
    starred = [p.kind is inspect.Parameter.KEYWORD_ONLY for p in found.parameters.values()]
    if any(starred):
        arguments.insert(starred.index(True), "*")
    short = f"{kind}{name}({', '.join(arguments)}){_returned(thing, found)}"
    if len(short) <= 100:
        return short
    lines = "".join(f"    {one},\n" for one in arguments)
    return f"{kind}{name}(\n{lines}){_returned(thing, found)}"


def _argument(one: inspect.Parameter) -> str:
    """An argument with its annotation as written; without it where a class checks it on entry."""
    default = "" if one.default is inspect.Parameter.empty else f" = {one.default}"
    text = one.name + default if "." in str(one.annotation) else str(one)
    text = re.sub(r": '([^']+)'", r": \1", text).replace("<factory>", "...")
    return re.sub(r"<function ([\w.]+) at \w+>", r"\1", text)


def _returned(thing: Any, found: inspect.Signature) -> str:
    if inspect.isclass(thing) or found.return_annotation is inspect.Signature.empty:
        return ""
    text = found.return_annotation
    return f" -> {text if isinstance(text, str) else getattr(text, '__name__', text)}"


def _members(thing: Any) -> Iterator[str]:
    """Properties and methods that a class itself defines, each with its first line."""
    if not inspect.isclass(thing):
        return
    rows = [
        (name, member)
        for name, member in vars(thing).items()
        if name[0] != "_" and (inspect.isfunction(member) or isinstance(member, property))
    ]
    if rows:
        yield "\n| member | what it is |\n|---|---|"
    for name, member in rows:
        label = name if isinstance(member, property) else f"{name}()"
        first = (inspect.getdoc(member) or "").split("\n\n")[0].replace("\n", " ")
        yield f"| `{label}` | {first} |"


def as_markdown(text: str) -> str:
    """A docstring with its examples as Python code; other indented lines stay code."""
    parts = re.split(r"\n\n", text)
    return "\n\n".join(_fenced(part) if part.lstrip().startswith(">>>") else part for part in parts)


def _fenced(part: str) -> str:
    return f"```python\n{inspect.cleandoc(part)}\n```"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
