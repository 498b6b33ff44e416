"""Which source files a stage runs through, so that a stage runs again when one of them changes.

Snakemake sees the shell command of a rule, not what it imports. The import statements of a module
are read without running it, and followed through the package: the fingerprint of a stage is the
hash of all the files found.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
"""Folder of the installed package, wherever the Snakefile stands."""

TEXT_SUFFIXES = {".py", ".html", ".css", ".js", ".txt", ".yaml", ".json"}


def fingerprint(*modules: str) -> str:
    """Short hash of the modules (`stages.keypoints`, ...) and of all that they import in here."""
    digest = hashlib.sha256()
    for path in sorted(_closure(modules)):
        digest.update(str(path.relative_to(PACKAGE)).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:12]


def source_files(*modules: str) -> list[str]:
    """Files, relative to the package, that the fingerprint of `modules` covers."""
    return sorted(str(path.relative_to(PACKAGE)) for path in _closure(modules))


def _closure(modules: tuple[str, ...]) -> set[Path]:
    seen: set[Path] = set()
    todo = [path for name in modules for path in _files(tuple(name.split(".")))]
    while todo:
        path = todo.pop()
        if path in seen:
            continue
        seen.add(path)
        if path.suffix == ".py":
            todo.extend(_imported(path))
    return seen


@cache
def _imported(path: Path) -> tuple[Path, ...]:
    """Files of the package that one module imports, those inside its functions included."""
    tree = ast.parse(path.read_bytes(), str(path))
    names = {name for node in ast.walk(tree) for name in _names(node, path)}
    return tuple(found for name in sorted(names) for found in _files(name))


def _names(node: ast.AST, path: Path) -> Iterator[tuple[str, ...]]:
    """Modules that one import statement may mean, as parts below the package."""
    if isinstance(node, ast.Import):
        names = [tuple(alias.name.split(".")) for alias in node.names]
        yield from (name[1:] for name in names if name[0] == PACKAGE.name and len(name) > 1)
    if isinstance(node, ast.ImportFrom):
        base = _base(node, path)
        yield from ((*base, alias.name) for alias in node.names if base is not None)


def _base(node: ast.ImportFrom, path: Path) -> tuple[str, ...] | None:
    parts = tuple(node.module.split(".")) if node.module else ()
    if node.level == 0:
        return parts[1:] if parts[:1] == (PACKAGE.name,) else None
    here = path.parent.relative_to(PACKAGE).parts
    return here[: len(here) - (node.level - 1)] + parts


def _files(name: tuple[str, ...]) -> list[Path]:
    """Files that importing `name` runs; a package that is taken whole counts with all its files.

    The last part may be a module, or something defined in the module before it.
    """
    parents = [PACKAGE.joinpath(*name[:depth], "__init__.py") for depth in range(1, len(name))]
    found = [path for path in parents if path.is_file()]
    target = PACKAGE.joinpath(*name)
    if target.is_dir():
        return found + _texts(target)
    if target.with_suffix(".py").is_file():
        return [*found, target.with_suffix(".py")]
    owner = PACKAGE.joinpath(*name[:-1])
    if owner.is_dir() and owner != PACKAGE:
        return found + _texts(owner)
    return [*found, owner.with_suffix(".py")] if owner.with_suffix(".py").is_file() else found


def _texts(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.suffix in TEXT_SUFFIXES]
