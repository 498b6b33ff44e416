"""steady.csv: a row a trial."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path

from ..data import SteadyState, write_columns
from ..errors import input_error

STEADY_NUMBER_COLUMNS = (
    "flap_hz",
    "speed_m_s",
    "speed_std_m_s",
    "radius_m",
    "radius_std_m",
    "arc_deg",
    "steady_from_s",
    "steady_to_s",
)
CENTER_COLUMNS = ("center_x_m", "center_y_m")
STEADY_COLUMNS = ("trial_id", *STEADY_NUMBER_COLUMNS, "quality", "reason", "turn", *CENTER_COLUMNS)
"""Columns of steady.csv."""


def write_steady(path: str | Path, steady: Mapping[str, SteadyState]) -> None:
    """Write steady.csv whole; an infinite radius as `inf`, NaN as an empty cell."""
    rows = list(steady.values())
    columns: dict[str, list[object]] = {"trial_id": list(steady)}
    for name in STEADY_NUMBER_COLUMNS:
        columns[name] = [_infinity_as_text(getattr(row, name)) for row in rows]
    columns["quality"] = [row.quality for row in rows]
    columns["reason"] = [row.reason for row in rows]
    columns["turn"] = [row.turn for row in rows]
    for i, name in enumerate(CENTER_COLUMNS):
        columns[name] = [row.center_m[i] for row in rows]
    write_columns(path, columns)


def read_steady(path: str | Path) -> dict[str, SteadyState]:
    """Steady states by trial id from steady.csv.

    Raises: InputError naming file, row and column of what cannot be read.
    """
    try:
        with Path(path).open(encoding="utf-8-sig", newline="") as lines:
            table = csv.DictReader(lines)
            missing = [name for name in STEADY_COLUMNS[:11] if name not in (table.fieldnames or [])]
            rows = list(table)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise input_error(path, "", f"an unreadable file ({error})", "steady.csv") from error
    if missing:
        raise input_error(path, "row 1", "other columns", f"a column {', '.join(missing)}")
    return {row["trial_id"]: _parse_steady_row(path, i, row) for i, row in enumerate(rows, start=2)}


def _parse_steady_row(path: str | Path, number: int, row: dict[str, str]) -> SteadyState:
    try:
        values = {name: _cell_to_float(row[name]) for name in STEADY_NUMBER_COLUMNS}
        x, y = (_cell_to_float(row.get(name, "")) for name in CENTER_COLUMNS)
        turn = int(float(row.get("turn") or 0))
    except (TypeError, ValueError) as error:
        raise input_error(path, f"row {number}", str(error), "numbers") from error
    return SteadyState(
        **values, quality=row["quality"], reason=row["reason"] or "", turn=turn, center_m=(x, y)
    )


def _cell_to_float(cell: str | None) -> float:
    return float(cell) if cell and cell.strip() else float("nan")


def _infinity_as_text(value: float) -> float | str:
    return "inf" if value == float("inf") else value
