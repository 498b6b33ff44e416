"""The order of the files of one recording.

GoPro names chapters `GXccnnnn.MP4` (HEVC), `GHccnnnn` (H.264) or `GPccnnnn` after a first
`GOPRnnnn`: cc the chapter, nnnn the recording; file-name order is wrong across recordings.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from ..errors import InputError, InputIssue, input_error

_CHAPTER_NAME_PATTERN = re.compile(r"(?i)(G[A-Z])(\d{2})(\d{4})")
_FIRST_CHAPTER_NAME_PATTERN = re.compile(r"(?i)GOPR(\d{4})")


def gopro_chapter(path: Path) -> tuple[str, int] | None:
    """(recording, chapter) of a GoPro file name, None for other names."""
    if match := _FIRST_CHAPTER_NAME_PATTERN.fullmatch(path.stem):
        return (f"GP{match[1]}", 1)
    if match := _CHAPTER_NAME_PATTERN.fullmatch(path.stem):
        first = 1 if match[1].upper() == "GP" else 0
        return (f"{match[1].upper()}{match[3]}", int(match[2]) + first)
    return None


def sort_chapters(paths: Sequence[Path]) -> tuple[Path, ...]:
    """The chapters of one recording in playing order; other names stay as they were given.

    Raises: InputError where a file is named twice, files of several recordings are mixed, or a
    chapter is missing.
    """
    if not paths:
        raise input_error("source", "", "no file", "a video file, or the chapters of one recording")
    if len(set(paths)) < len(paths):
        raise input_error(paths[0], "", "a file named twice", "each chapter once")
    marks = [gopro_chapter(path) for path in paths]
    known = [mark for mark in marks if mark is not None]
    if len(paths) == 1 or not known:
        return tuple(paths)
    if len(known) < len(paths) or len({recording for recording, _ in known}) > 1:
        names = ", ".join(path.name for path in paths)
        raise input_error(paths[0], "", f"files of several recordings ({names})", "chapters of one")
    ordered = sorted(zip(known, paths, strict=True))
    _check_chapters_complete([mark[1] for mark, _ in ordered], [path for _, path in ordered])
    return tuple(path for _, path in ordered)


def _check_chapters_complete(numbers: list[int], paths: list[Path]) -> None:
    missing = sorted(set(range(1, numbers[-1] + 1)) - set(numbers))
    if missing:
        text = ", ".join(f"{number:02d}" for number in missing)
        raise InputError(
            InputIssue(
                str(paths[0]),
                "chapters",
                f"chapter {text} missing among {', '.join(path.name for path in paths)}",
                f"all chapters 01 to {numbers[-1]:02d} of the recording",
                "Copy the missing file from the camera's card; time would jump without it.",
            )
        )


def unlisted_chapters(paths: Sequence[Path]) -> tuple[str, ...]:
    """Names of further chapters of this recording that lie beside the first file, unnamed."""
    mark = gopro_chapter(paths[0])
    if mark is None or not paths[0].parent.is_dir():
        return ()
    given = {path.name.lower() for path in paths}
    suffix = paths[0].suffix.lower()
    beside = [
        path.name
        for path in paths[0].parent.iterdir()
        if path.suffix.lower() == suffix
        and path.name.lower() not in given
        and (gopro_chapter(path) or ("", 0))[0] == mark[0]
    ]
    return tuple(sorted(beside))
