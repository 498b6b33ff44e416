"""DeepLabCut's csv: header rows scorer / [individuals] / bodyparts / coords, then a row a frame."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ...errors import InputError, did_you_mean, input_error, unreadable_reason
from ...files import binary_format
from .table import Table, build_table, frame_numbers

HEADER_ROW_NAMES = ("scorer", "individuals", "bodyparts", "coords")
COORDINATES = ("x", "y", "likelihood")
EXPECTED_LAYOUT = "DeepLabCut's header rows scorer, bodyparts, coords"


def read_dlc_csv(path: Path) -> Table:
    """Table of a DeepLabCut csv of predictions or labels, of one animal or several.

    Raises: InputError naming the row where the header is not DeepLabCut's, the body is empty, a row
    has another number of cells, or a cell is no number.
    """
    rows = _nonempty_rows(path)
    header, body = _split_header(path, rows)
    first = next((i for i, cell in enumerate(header["coords"]) if cell in COORDINATES), 0)
    if first == 0:
        raise input_error(
            path, "coords", ", ".join(header["coords"][:4]), "x, y[, likelihood] a part"
        )
    _check_coordinates(path, header, first)
    width = len(header["coords"])
    if not body:
        raise input_error(path, "", "a header without a single frame", "a row a frame")
    values = _parse_cells(path, body, first, header)
    kept = [i for i in range(first, width) if header["coords"][i] in COORDINATES]
    who = header.get("individuals", [""] * width)
    labels = [(who[i], header["bodyparts"][i], header["coords"][i]) for i in kept]
    index = ["/".join(cell.strip() for cell in row[:first]) for _, row in body]
    lines = [number for number, _ in body]
    frame = frame_numbers(index, path, lines)
    return build_table(path, labels, values[:, [i - first for i in kept]], frame, lines)


def _nonempty_rows(path: Path) -> list[tuple[int, list[str]]]:
    """Line numbers and cells of all rows that hold anything at all."""
    if kind := binary_format(path):
        remedy = "Give it the ending .h5, also in trials.csv." if "HDF5" in kind else ""
        raise input_error(path, "", kind, "a DeepLabCut csv in UTF-8",
                          remedy or "Save it as CSV UTF-8.")  # fmt: skip
    try:
        with path.open(encoding="utf-8-sig", newline="") as lines:
            rows = [(i, row) for i, row in enumerate(csv.reader(lines), start=1) if any(row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise input_error(
            path, "", f"no readable csv ({unreadable_reason(error)})", "a DeepLabCut csv in UTF-8"
        ) from error
    if not rows:
        raise input_error(path, "", "an empty file", "a DeepLabCut csv")
    for number, row in rows:
        if any("\n" in cell for cell in row):
            raise input_error(path, f"row {number}",
                              "a quotation mark that is not closed in its row",
                        "a row a frame", "Take the mark out, or close it.")  # fmt: skip
    return rows


def _split_header(
    path: Path, rows: list[tuple[int, list[str]]]
) -> tuple[dict[str, list[str]], list[tuple[int, list[str]]]]:
    header: dict[str, list[str]] = {}
    for _, row in rows[: len(HEADER_ROW_NAMES)]:
        name = row[0].strip().lower()
        if name not in HEADER_ROW_NAMES or name in header:
            break
        header[name] = [cell.strip() for cell in row]
    missing = [name for name in ("scorer", "bodyparts", "coords") if name not in header]
    if missing:
        found = f"no row '{missing[0]}' in the header (row 1: {', '.join(rows[0][1])[:80]})"
        other = next((c for c in ";\t" if len(rows[0][1]) == 1 and c in rows[0][1][0]), "")
        name = {";": "semicolons", "\t": "tabs"}.get(other, "")
        remedy = f"The cells are separated by {name}: save it with commas." if other else ""
        raise input_error(path, "header", found, EXPECTED_LAYOUT, remedy)
    widths = {name: len(row) for name, row in header.items()}
    if len(set(widths.values())) > 1:
        raise input_error(
            path, "header", f"rows of {sorted(set(widths.values()))} cells", EXPECTED_LAYOUT
        )
    return header, rows[len(header) :]


def _check_coordinates(path: Path, header: dict[str, list[str]], first: int) -> None:
    """Raises: InputError for a column of another name, or a part that lacks a likelihood."""
    for number, name in enumerate(header["coords"][first:], start=first + 1):
        if name not in COORDINATES:
            raise input_error(
                path, f"coords, column {number}", f"'{name}'", ", ".join(COORDINATES),
                did_you_mean(name, COORDINATES),
            )  # fmt: skip
    owners = header.get("individuals", [""] * len(header["coords"]))
    points = list(zip(owners, header["bodyparts"], header["coords"], strict=True))[first:]
    rated = {(who, part) for who, part, name in points if name == "likelihood"}
    bare = [part for who, part, _ in points if (who, part) not in rated]
    if rated and bare:
        found = f"part '{bare[0]}' without a likelihood, which others have"
        raise input_error(path, "coords", found, "a likelihood for each part, or for none",
                          "Was a column cut off?")  # fmt: skip


def _parse_cells(
    path: Path, body: list[tuple[int, list[str]]], first: int, header: dict[str, list[str]]
) -> npt.NDArray[np.float64]:
    width = len(header["coords"])
    for number, row in body:
        if len(row) != width:
            remedy = "Was the file cut while it was copied?"
            raise input_error(
                path, f"row {number}", f"{len(row)} cells", f"{width} cells, as the header", remedy
            )
    try:
        return np.array([[_number_of_cell(cell) for cell in row[first:]] for _, row in body])
    except ValueError:
        raise _not_a_number_error(path, body, first, header) from None


def _not_a_number_error(
    path: Path, body: list[tuple[int, list[str]]], first: int, header: dict[str, list[str]]
) -> InputError:
    for number, row in body:
        for i, cell in enumerate(row[first:], start=first):
            try:
                _number_of_cell(cell)
            except ValueError:
                place = f"row {number}, {header['bodyparts'][i]} {header['coords'][i]}"
                return input_error(path, place, f"'{cell[:60]}'", "a number or an empty cell")
    return input_error(path, "", "a cell that is no number", "numbers")


def _number_of_cell(cell: str) -> float:
    """A cell's number, NaN for an empty one. Raises: ValueError for another text, also 1_000."""
    if "_" in cell:
        raise ValueError(cell)
    return float(cell or "nan")
