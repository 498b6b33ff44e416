"""DeepLabCut's h5 (a pandas DataFrame in PyTables layout), read with h5py alone.

Fixed format: axis0 / axis1 levels and labels, block values. Table format: a compound dataset
whose column names are a pickle, which is read as text (`pickle_literals.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...data import Float
from ...errors import input_error
from .pickle_literals import parse_literal
from .safe_h5 import h5_member_without_links, open_h5, read_h5_strings
from .table import Table, build_table, frame_numbers

COORDINATES = ("x", "y", "likelihood")


def read_h5(path: Path) -> Table:
    """Table of a DeepLabCut h5.

    Raises: InputError where it is no such file, is damaged, or holds anything that would have to be
    unpickled.
    """
    with open_h5(path) as file:
        group = _dataframe_group(file)
        if group is None:
            raise input_error(path, "", "no DataFrame in this h5", "DeepLabCut's df_with_missing")
        fixed = h5_member_without_links(group, "table") is None
        labels, values, index = _read_fixed_format(group) if fixed else _read_table_format(group)
    if len(values) == 0 or values.shape[1] != len(labels):
        raise input_error(path, "", "a file without a single frame", "a row a frame",
                          "Export the keypoints again.")  # fmt: skip
    kept = [i for i, label in enumerate(labels) if label[-1] in COORDINATES]
    named = [_individual_part_coordinate(labels[i]) for i in kept]
    if not named:
        raise input_error(path, "columns", "no x and y", "DeepLabCut's columns")
    return build_table(path, named, values[:, kept], frame_numbers(index, path))


def _individual_part_coordinate(label: Sequence[str]) -> tuple[str, str, str]:
    """(individual, part, coordinate) of a column (scorer, [individual,] part, coordinate)."""
    return (label[1] if len(label) == 4 else "", label[-2], label[-1])


def _dataframe_group(file: Any) -> Any:
    """The first group that pandas wrote, the usual name first."""
    for name in ("df_with_missing", *file.keys()):
        group = h5_member_without_links(file, name)
        if group is not None and hasattr(group, "keys") and "pandas_type" in group.attrs:
            return group
    return None


def _read_fixed_format(group: Any) -> tuple[list[tuple[str, ...]], Float, list[str]]:
    labels: list[tuple[str, ...]] = []
    parts: list[Float] = []
    for number in range(int(group.attrs["nblocks"])):
        labels += _axis_labels(group, f"block{number}_items")
        block = h5_member_without_links(group, f"block{number}_values")
        if block.dtype.kind not in "fiu":
            raise ValueError("cells stored as pickled objects, which are not read")
        parts.append(np.asarray(block[()], dtype=float).reshape(block.shape[0], -1))
    index = ["/".join(row) for row in _axis_labels(group, "axis1")]
    return labels, np.concatenate(parts, axis=1), index


def _axis_labels(group: Any, name: str) -> list[tuple[str, ...]]:
    """Entries of an axis, a tuple of its levels each."""
    if h5_member_without_links(group, f"{name}_level0") is None:
        return [(text,) for text in _as_strings(h5_member_without_links(group, name))]
    levels = []
    count = int(group.attrs.get(f"{name}_nlevels", 1))
    for k in range(min(count, 6)):
        known = _as_strings(h5_member_without_links(group, f"{name}_level{k}"))
        codes = h5_member_without_links(group, f"{name}_label{k}")[()]
        levels.append([known[int(code)] for code in codes])
    return list(zip(*levels, strict=True))


def _as_strings(dataset: Any) -> list[str]:
    if dataset.dtype.kind in "iuf":
        return [format(value, "g") if value < 1e6 else str(value) for value in dataset[()].ravel()]
    if dataset.dtype.kind == "S":
        return read_h5_strings(dataset)
    raise ValueError("names stored as pickled objects, which are not read")


def _read_table_format(group: Any) -> tuple[list[tuple[str, ...]], Float, list[str]]:
    table = h5_member_without_links(group, "table")
    rows = table[()]
    labels: list[tuple[str, ...]] = []
    parts: list[Float] = []
    for name in rows.dtype.names:
        if f"{name}_kind" in table.attrs and name.startswith("values_block"):
            labels += [
                _column_levels(c) for c in parse_literal(_as_bytes(table.attrs[f"{name}_kind"]))
            ]
            parts.append(np.asarray(rows[name], dtype=float).reshape(len(rows), -1))
    values = np.concatenate(parts, axis=1)
    if len(labels) != values.shape[1]:
        raise ValueError(f"{len(labels)} names for {values.shape[1]} columns")
    index = rows["index"].tolist() if "index" in rows.dtype.names else range(len(rows))
    return labels, values, [_decode_utf8(cell) for cell in index]


def _column_levels(entry: Any) -> tuple[str, ...]:
    """Levels of a column name, which is a tuple, or its text where pandas flattened it."""
    if isinstance(entry, tuple):
        return tuple(str(level) for level in entry)
    raise ValueError(f"a column name {entry!r} that is no tuple")


def _as_bytes(attribute: Any) -> bytes:
    return attribute if isinstance(attribute, bytes) else bytes(np.bytes_(attribute))


def _decode_utf8(cell: Any) -> str:
    return cell.decode("utf-8", "replace") if isinstance(cell, bytes) else str(cell)
