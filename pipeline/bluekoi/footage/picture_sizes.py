"""Pictures of a recording that cannot be used: of another size than most, or not readable."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import cv2
from PIL import Image
from PIL.ExifTags import Base

Size = tuple[int, int]
FIRST_TRANSPOSED_EXIF_ORIENTATION = 5
"""Orientation in a picture's Exif data from which width and height are exchanged."""
MAX_LISTED_PICTURES = 3
"""Pictures that a remark names; it counts the others."""


def picture_size_px(path: Path) -> Size | None:
    """Size (width, height) of a picture as shown, by its header; None if it cannot be read."""
    try:
        with Image.open(path) as picture:
            exif = picture.getexif() if "exif" in picture.info else {}
            turned = exif.get(Base.Orientation, 1) >= FIRST_TRANSPOSED_EXIF_ORIENTATION
            return picture.size[::-1] if turned else picture.size
    except Exception:  # a damaged header raises errors of many kinds
        found = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        return None if found is None else (int(found.shape[1]), int(found.shape[0]))


def unused_picture_remarks(
    paths: Sequence[Path], sizes: Sequence[Size | None]
) -> tuple[tuple[bool, ...], tuple[str, ...]]:
    """Whether each picture has the size of most of them, and sentences that name the others."""
    known = [size for size in sizes if size is not None]
    if not known:
        return (False,) * len(paths), ()
    usual, _ = Counter(known).most_common(1)[0]
    found = []
    other = [(path, size) for path, size in zip(paths, sizes, strict=True)
           if size is not None and size != usual]  # fmt: skip
    if other:
        names = _abbreviated_name_list(
            [f"{path.name} ({_size_text(size)})" for path, size in other]
        )
        found.append(
            f"{_count_of_pictures_text(len(other), len(paths))} not used, expected "
            f"{_size_text(usual)} as in most of them: {names}"
        )
    if broken := [path.name for path, size in zip(paths, sizes, strict=True) if size is None]:
        found.append(
            f"{_count_of_pictures_text(len(broken), len(paths))} not readable: "
            f"{_abbreviated_name_list(broken)}"
        )
    return tuple(size == usual for size in sizes), tuple(found)


def _size_text(size: Size) -> str:
    return f"{size[0]} x {size[1]} px"


def _count_of_pictures_text(count: int, of: int) -> str:
    return f"{count} of {of} pictures {'is' if count == 1 else 'are'}"


def _abbreviated_name_list(names: Sequence[str]) -> str:
    """The first names, and how many more there are."""
    more = len(names) - MAX_LISTED_PICTURES
    shown = ", ".join(names[:MAX_LISTED_PICTURES])
    return f"{shown} and {more} more" if more > 0 else shown
