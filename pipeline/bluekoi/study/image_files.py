"""Pictures as a recording: a folder of them, or a pattern of file names."""

from __future__ import annotations

import os
import re
from pathlib import Path

IMAGE_SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pgm")
IMAGE_PATTERN = re.compile(r"[*?\[]|%0?\d*d")
"""Signs in a source by which it is a pattern of picture files."""


def is_image_source(name: str) -> bool:
    """Whether a source names pictures by its form alone: a pattern, a picture, or a folder (no
    ending, or a slash at the end).
    """
    suffix = Path(name).suffix.lower()
    return suffix in IMAGE_SUFFIXES or name.endswith("/") or not suffix


def with_slash_after_folders(root: Path, source: str) -> str:
    """A source with a slash after each name that looks like a file's and is a folder's."""
    return ";".join(
        f"{name.rstrip()}/"
        if not is_image_source(name.strip()) and os.path.isdir(root / name.strip())
        else name
        for name in source.split(";")
    )


def natural_sort_key(name: str) -> list[tuple[int, int, str]]:
    """Sort key by which 2 comes before 10."""
    parts = re.split(r"(\d+)", name.casefold())
    return [(1, int(part), "") if part.isdecimal() else (0, 0, part) for part in parts]


def expand_source(root: Path, name: str) -> tuple[Path, ...]:
    """Files that a source stands for, pictures in natural order; the path itself where it is a
    file, or nothing is found.

    A pattern has `*`, `?`, `[...]` or a number as `%05d`; it is relative to `root`, or absolute.
    """
    path = root / name
    if IMAGE_PATTERN.search(name) and not path.exists():
        found = _files_matching_pattern(path)
    elif path.is_dir():
        found = [one for one in path.iterdir() if _is_picture(one)]
    else:
        return (path,)
    return tuple(sorted(found, key=lambda one: natural_sort_key(str(one)))) or (path,)


def _files_matching_pattern(path: Path) -> list[Path]:
    """Pictures that a pattern stands for; a number is digits alone. The name of a folder that is
    there is no pattern, whatever signs are in it.
    """
    parts = path.relative_to(path.anchor).parts
    base, fixed = Path(path.anchor), 0
    while fixed < len(parts) - 1 and (base / parts[fixed]).is_dir():
        base, fixed = base / parts[fixed], fixed + 1
    shell = "/".join(re.sub(r"%0?\d*d", "*", part) for part in parts[fixed:])
    form = re.compile(_pattern_to_regex(parts[-1]), re.IGNORECASE)
    found = base.glob(shell)
    return [one for one in found if _is_picture(one) and form.fullmatch(one.name)]


def _is_picture(path: Path) -> bool:
    """Whether a file name is that of a picture; macOS companion files `._name` are excluded."""
    return path.suffix.lower() in IMAGE_SUFFIXES and not path.name.startswith("._")


def _pattern_to_regex(part: str) -> str:
    """Regular expression of a file name in which `%05d` is digits; any name without one."""
    if not re.search(r"%0?\d*d", part):
        return ".*"
    words = re.split(r"%0?\d*d", part)
    return r"\d+".join(re.escape(word) for word in words) if "*" not in part else ".*"
