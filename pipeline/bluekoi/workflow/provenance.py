"""Source files that a stage depends on: it runs again when one of them changes.

Snakemake sees the shell command of a rule, not what it imports. The import statements of a module
are read without running it, and followed through the package: the fingerprint of a stage is the
hash of all the files found.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

PACKAGE_FOLDER = Path(__file__).resolve().parents[1]
"""Folder of the installed package, wherever the Snakefile stands."""

TEXT_SUFFIXES = {".py", ".html", ".css", ".js", ".txt", ".yaml", ".json"}
IMPORT_STATEMENT_PATTERN = re.compile(
    r"^[ \t]*(?:from[ ]+(?P<base>[.\w]+)[ ]+import[ ]+(?P<names>\([^)]*\)|[^\n]+)"
    r"|import[ ]+(?P<modules>[^\n]+))",
    re.M,
)
"""An import statement; to parse whole files takes ten times as long."""
COMMENT_PATTERN = re.compile(r"#[^\n]*")


def source_fingerprint(*modules: str) -> str:
    """Short hash of the modules (`stages.keypoints`, ...) and of all that they import in here."""
    digest = hashlib.sha256()
    for path in sorted(_import_closure(modules)):
        digest.update(f"{path.relative_to(PACKAGE_FOLDER)} {_hash_and_imports(path)[0]}\n".encode())
    return digest.hexdigest()[:12]


def source_files(*modules: str) -> list[str]:
    """Files, relative to the package, that the fingerprint of `modules` covers."""
    return sorted(str(path.relative_to(PACKAGE_FOLDER)) for path in _import_closure(modules))


def _import_closure(modules: tuple[str, ...]) -> set[Path]:
    seen: set[Path] = set()
    parts = [tuple(name.split(".")) for name in modules]
    todo = [path for name in parts for path in _module_files(PACKAGE_FOLDER, name)]
    while todo:
        path = todo.pop()
        if path not in seen:
            seen.add(path)
            todo.extend(_hash_and_imports(path)[1])
    return seen


@cache
def _hash_and_imports(path: Path) -> tuple[str, tuple[Path, ...]]:
    """Hash of a file, and the files of the package that it imports, in functions as well."""
    content = path.read_bytes()
    text = content.decode() if path.suffix == ".py" else ""
    statements = IMPORT_STATEMENT_PATTERN.finditer(text)
    names = {name for one in statements for name in _imported_names(one, path)}
    files = tuple(file for name in sorted(names) for file in _module_files(PACKAGE_FOLDER, name))
    return hashlib.sha256(content).hexdigest(), files


def _imported_names(found: re.Match[str], path: Path) -> Iterator[tuple[str, ...]]:
    """Modules that an import statement (match of `IMPORT_STATEMENT_PATTERN`) may import, as name
    parts below the package.
    """
    listed = COMMENT_PATTERN.sub("", found["names"] or found["modules"]).strip("() \n")
    words = [part.split()[0] for part in listed.split(",") if part.strip()]
    if found["modules"]:
        parts = [tuple(word.split(".")) for word in words]
        yield from (name[1:] for name in parts if name[0] == PACKAGE_FOLDER.name and len(name) > 1)
    elif (base := _name_in_package(found["base"], path)) is not None:
        yield from ((*base, word) for word in words)


def _name_in_package(name: str, path: Path) -> tuple[str, ...] | None:
    """Parts below the package of a module name in `path`, relative or not; None if outside it."""
    module = name.lstrip(".")
    level, parts = len(name) - len(module), tuple(module.split(".")) if module else ()
    if level == 0:
        return parts[1:] if parts[:1] == (PACKAGE_FOLDER.name,) else None
    here = path.parent.relative_to(PACKAGE_FOLDER).parts
    return here[: len(here) - (level - 1)] + parts


@cache
def _module_files(package: Path, name: tuple[str, ...]) -> list[Path]:
    """Files that importing `name` runs; a package that is taken whole counts with all its files.

    The last part may be a module, or something defined in the module before it.
    """
    parents = [package.joinpath(*name[:depth], "__init__.py") for depth in range(1, len(name))]
    found = [path for path in parents if path.is_file()]
    target = package.joinpath(*name)
    if target.is_dir():
        return found + _text_files(target)
    if target.with_suffix(".py").is_file():
        return [*found, target.with_suffix(".py")]
    owner = package.joinpath(*name[:-1])
    if owner.is_dir() and owner != package:
        return found + _text_files(owner)
    return [*found, owner.with_suffix(".py")] if owner.with_suffix(".py").is_file() else found


def _text_files(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.suffix in TEXT_SUFFIXES]
