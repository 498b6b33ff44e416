"""Equally long columns as csv: written whole or not at all, read with the place of every fault."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import input_error
from ..files import atomic_write, binary_format, read_text
from .types import Float


def write_columns(path: str | Path, columns: dict[str, Any]) -> None:
    """Write equally long columns as csv, whole or not at all; NaN as an empty cell."""
    names = list(columns)
    rows = zip(*map(_format_column, columns.values()), strict=True)
    with atomic_write(path) as temporary, temporary.open("w", encoding="utf-8") as out:
        out.write(",".join(names) + "\n")
        out.writelines(",".join(row) + "\n" for row in rows)


def read_columns(path: str | Path, required: tuple[str, ...]) -> dict[str, Float]:
    """Numeric columns of a csv by name; empty cells are NaN.

    Raises: InputError naming the file and the missing column, or the row with a wrong cell.
    """
    if kind := binary_format(Path(path)):
        raise input_error(path, "", kind, "a csv file in UTF-8", "Save it as CSV UTF-8.")
    try:
        text = read_text(path)
    except (OSError, UnicodeDecodeError) as error:
        raise input_error(
            path, "", f"an unreadable file ({error})", "a csv file in UTF-8"
        ) from error
    lines = [(i, line) for i, line in enumerate(text.splitlines(), start=1) if line.strip()]
    if not lines:
        raise input_error(path, "", "an empty file", f"a csv with columns {', '.join(required)}")
    names = _parse_column_names(path, *lines[0], required)
    table = np.array([_parse_row(path, i, line, len(names)) for i, line in lines[1:]])
    table = table.reshape(len(lines) - 1, len(names))
    return {name: table[:, i] for i, name in enumerate(names)}


def _parse_column_names(
    path: str | Path, number: int, line: str, required: tuple[str, ...]
) -> list[str]:
    names = [cell.strip().strip('"') for cell in line.split(",")]
    row, found = f"row {number}", f"columns {', '.join(names)[:200]}"
    if missing := [name for name in required if name not in names]:
        comma = ", separated by commas" if ";" in line or "\t" in line else ""
        raise input_error(path, row, found, f"a column {', '.join(missing)}{comma}")
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise input_error(path, row, f"{', '.join(twice)[:200]} more than once", "each column once")
    return names


def _parse_row(path: str | Path, number: int, line: str, width: int) -> list[float]:
    cells = line.split(",")
    if len(cells) != width:
        raise input_error(path, f"row {number}", f"{len(cells)} cells", f"{width} cells")
    if "_" in line:  # which Python's float leaves out: 1_000
        found = next(cell for cell in cells if "_" in cell)
        raise input_error(path, f"row {number}", repr(found), "a number without underscores")
    try:
        values = [float(cell) if cell else math.nan for cell in cells]
    except ValueError:  # as a cell with quotes or blanks, which are rare
        cells = [cell.strip().strip('"') for cell in cells]
        try:
            values = [float(cell) if cell else math.nan for cell in cells]
        except ValueError as error:
            raise input_error(path, f"row {number}", str(error), "numbers") from error
    if math.inf in values or -math.inf in values:
        found = next(cell for cell, x in zip(cells, values, strict=True) if math.isinf(x))
        raise input_error(path, f"row {number}", repr(found), "a finite number")
    return values


def _format_column(column: Any) -> Iterable[str]:
    if isinstance(column, np.ndarray) and column.dtype.kind == "f":
        return [f"{x:.9g}" if math.isfinite(x) else "" for x in column.tolist()]
    return map(_format_cell, column)


def _format_cell(value: Any) -> str:
    if isinstance(value, str):
        return '"' + value.replace('"', '""') + '"' if set(value) & set(',"\n') else value
    if isinstance(value, (bool, np.bool_, int, np.integer)):
        return str(int(value))
    return "" if not np.isfinite(value) else format(float(value), ".9g")
