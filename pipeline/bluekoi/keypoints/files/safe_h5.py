"""h5 files opened with care: no links out of the file, no unbounded sizes, no pickled objects."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py

from ...errors import input_error
from ...files import binary_format

MAX_DATASET_ELEMENTS = 50_000_000
TEXT_SNIFF_BYTES = 512
"""A file whose first bytes are all printable is text."""


def format_if_not_h5(path: Path) -> str:
    """What a file is that is certainly no h5: a workbook or text; "" for others."""
    kind = binary_format(path)
    if kind:
        return "" if "HDF5" in kind else kind
    with path.open("rb") as content:
        head = content.read(TEXT_SNIFF_BYTES)
    printable = all(byte >= 0x20 or byte in b"\t\r\n" for byte in head)
    return "text, as in a csv file" if head and printable else ""


@contextmanager
def open_h5(path: Path) -> Iterator[Any]:
    """An open h5 file; what goes wrong while reading it becomes a InputError that names it."""
    if kind := format_if_not_h5(path):
        raise input_error(
            path, "", kind, "a DeepLabCut or SLEAP h5", "Its ending must be that of its format."
        )
    try:
        with h5py.File(path, "r") as file:
            yield file
    except (OSError, KeyError, ValueError, TypeError, RuntimeError, OverflowError) as error:
        reason = " ".join(str(error).split())[:200]
        raise input_error(
            path, "", f"no readable h5 ({reason})", "a DeepLabCut or SLEAP h5"
        ) from error
    except (MemoryError, RecursionError, AttributeError, IndexError) as error:
        raise input_error(
            path, "", f"a damaged h5 ({type(error).__name__})", "a whole file"
        ) from error


def h5_member_without_links(group: Any, name: str) -> Any:
    """Dataset or group `name` that truly lies in this file, None where there is none.

    Raises: ValueError for links out of the file, virtual or external storage, absurd sizes.
    """
    link = group.get(name, getlink=True)
    if link is None:
        return None
    if not isinstance(link, h5py.HardLink):
        raise ValueError(f"'{name}' is a link to elsewhere")
    item = group[name]
    if isinstance(item, h5py.Dataset):
        if item.external or item.is_virtual:
            raise ValueError(f"'{name}' is stored in another file")
        if item.size is not None and item.size > MAX_DATASET_ELEMENTS:
            raise ValueError(f"'{name}' has {item.size} cells")
    return item


def read_h5_strings(dataset: Any) -> list[str]:
    """Text of a dataset of names (fixed or variable length)."""
    cells = dataset[()].ravel().tolist()
    return [c.decode("utf-8", "replace") if isinstance(c, bytes) else str(c) for c in cells]
