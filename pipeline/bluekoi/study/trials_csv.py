"""trials.csv as checked `Trial`s."""

from __future__ import annotations

import csv
import io
import math
from collections import Counter
from pathlib import Path

from pydantic import ValidationError

from ..errors import InputIssue, did_you_mean, unreadable_reason
from ..files import binary_format, read_text
from .consistency_rules import is_too_long_path
from .image_files import is_image_source, with_slash_after_folders
from .types import KEYPOINT_SUFFIXES, VIDEO_SUFFIXES, Trial
from .validation_messages import (
    DECIMAL_POINT_REMEDY,
    issues_of_refused_values,
    shortened_repr,
)

MAX_CSV_BYTES, MAX_TRIALS = 10_000_000, 10_000
"""Ten times the largest study that was tried; a larger file is hardly a list of trials."""
NumberedCells = list[tuple[int, list[str]]]
MAX_LISTED_COLUMNS, MAX_SHOWN_NAME = 5, 40
"""Unknown columns that are listed one by one, and characters of a name that are compared."""
EXPECTED_PATH_TEXT = "a path without '..': relative to the study folder, or absolute"
EXPECTED_PATH_WITHOUT_NUL_TEXT = "a path without NUL characters (\\x00), which no file name has"
SAVE_AS_UTF8_REMEDY = "Save it as CSV UTF-8."
UNCLOSED_QUOTE_REMEDY = "Take the mark out, or close it."
READ_ERRORS = (OSError, UnicodeDecodeError, csv.Error)


def read_trials(
    path: Path, findings: list[InputIssue], *, only: str | None = None, root: Path | None = None
) -> list[Trial]:
    """The good rows of a trials.csv; errors of the others go to `findings`.

    only: this trial's rows alone, if there are any: to check a thousand takes longer than to read
    one trial's keypoints. root: folder to which the sources are relative, if not the file's own.
    """
    rows = _read_numbered_rows(path, findings)
    if not rows:
        return []
    names = [cell.strip() for cell in rows[0][1]]
    header = _header_findings(str(path), rows[0][0], names)
    findings.extend(header)
    if header:
        return []
    of_trial = [row for row in rows[1:] if _trial_id_in_row(names, row[1]) == only]
    wanted = rows[1:] if only is None or not of_trial else of_trial
    trials = [
        _parse_trial(path, root or path.parent, (number, names, row), findings)
        for number, row in wanted
    ]
    known = [trial for trial in trials if trial is not None]
    ids = [(number, trial.trial_id)
           for (number, _), trial in zip(wanted, trials, strict=True) if trial]  # fmt: skip
    findings.extend(_duplicate_id_findings(str(path), ids))
    if only is None and known and all(trial.role == "held_out" for trial in known):
        findings.append(InputIssue(str(path), "role", "every trial held out", "one or more to fit"))
    return known


def read_incomplete_trials(path: Path) -> list[Trial]:
    """Trials of a trials.csv in which cells may be empty or wrong: trial_id, source, motor_log and
    fps alone, unchecked.
    """
    rows = _read_numbered_rows(path, [])
    names = [cell.strip() for cell in rows[0][1]] if rows else []
    cells = [dict(zip(names, map(str.strip, row), strict=False)) for _, row in rows[1:]]
    return [
        Trial.model_construct(
            trial_id=row.get("trial_id", ""),
            source=with_slash_after_folders(
                path.parent, _without_impossible_file_names(row.get("source", ""))
            ),
            motor_log=_without_impossible_file_names(row.get("motor_log", "")) or None,
            fps=_positive_number(row.get("fps", "")),
        )
        for row in cells
    ]


def _without_impossible_file_names(source: str) -> str:
    """A source without the names that no file can have."""
    names = source.split(";")
    return ";".join(name for name in names if "\0" not in name and not is_too_long_path(name))


def _positive_number(text: str) -> float | None:
    try:
        found = float(text)
    except ValueError:
        return None
    return found if 0 < found < math.inf else None


def _trial_id_in_row(names: list[str], row: list[str]) -> str | None:
    """The trial_id of a row, where it has one."""
    at = names.index("trial_id")
    return row[at].strip() if at < len(row) else None


def _read_numbered_rows(path: Path, findings: list[InputIssue]) -> NumberedCells:
    """Rows that are not blank, each with the number of its first line in the file."""
    try:
        if kind := binary_format(path):
            findings.append(
                InputIssue(str(path), "", kind, "a csv file in UTF-8", SAVE_AS_UTF8_REMEDY)
            )
            return []
        rows = _numbered_rows(read_text(path, MAX_CSV_BYTES))
    except FileNotFoundError:
        findings.append(InputIssue(str(path), "", "no such file", "a trials.csv, one row a trial"))
        return []
    except READ_ERRORS as error:
        remedy = SAVE_AS_UTF8_REMEDY if isinstance(error, UnicodeDecodeError) else ""
        found = f"no readable csv ({unreadable_reason(error)})"
        findings.append(InputIssue(str(path), "", found, "a csv file in UTF-8", remedy))
        return []
    wrong = _table_finding(str(path), rows)
    findings.extend([wrong] if wrong else [])
    return [] if wrong else rows


def _table_finding(path: str, rows: NumberedCells) -> InputIssue | None:
    """What is wrong with a table as a whole: too many rows, none, or a quotation mark left open."""
    if len(rows) > MAX_TRIALS + 1:
        expected, remedy = f"{MAX_TRIALS} trials at most", "Split it into several studies."
        return InputIssue(path, "", f"{len(rows) - 1} rows", expected, remedy)
    if open_quote := next((n for n, row in rows if any("\n" in cell for cell in row)), None):
        found, remedy = "a quotation mark that is not closed in its row", UNCLOSED_QUOTE_REMEDY
        return InputIssue(path, f"row {open_quote}", found, "a row a trial", remedy)
    if len(rows) < 2:
        found = "a header without rows" if rows else "an empty file"
        return InputIssue(path, "", found, "a header and a row a trial")
    return None


def _numbered_rows(text: str) -> NumberedCells:
    """Rows of a csv that are not blank, each with the number of its first line."""
    reader = csv.reader(io.StringIO(text, newline=""))
    rows, before = [], 0
    for row in reader:
        if any(cell.strip() for cell in row):
            rows.append((before + 1, row))
        before = reader.line_num
    return rows


def _header_findings(path: str, number: int, names: list[str]) -> list[InputIssue]:
    where = f"row {number}"
    known = list(Trial.model_fields)
    required = [name for name, info in Trial.model_fields.items() if info.is_required()]
    if len(names) == 1 and (";" in names[0] or "\t" in names[0]):
        return [InputIssue(path, where, f"one column '{names[0]}'", "columns separated by commas",
                           DECIMAL_POINT_REMEDY)]  # fmt: skip
    others = [name for name in names if name not in known]
    unknown = [
        InputIssue(
            path,
            where,
            f"unknown column {shortened_repr(name)}",
            "a known column",
            did_you_mean(name[:MAX_SHOWN_NAME], known),
        )
        for name in others[:MAX_LISTED_COLUMNS]
    ]
    if (more := len(others) - MAX_LISTED_COLUMNS) > 0:
        unknown.append(InputIssue(path, where, f"{more} further unknown columns", "known columns"))
    missing = [
        InputIssue(path, where, f"no column '{name}'", f"the columns {', '.join(required)}")
        for name in required
        if name not in names
    ]
    repeated = [
        InputIssue(
            path,
            where,
            f"column {shortened_repr(name)} {'twice' if times == 2 else f'{times} times'}",
            "each column once",
        )
        for name, times in Counter(names).most_common(MAX_LISTED_COLUMNS)
        if times > 1
    ]
    return unknown + missing + repeated


def _parse_trial(
    file: Path, root: Path, numbered: tuple[int, list[str], list[str]], findings: list[InputIssue]
) -> Trial | None:
    """The trial of a row; None where something is wrong, with the errors in `findings`.

    numbered: the row's number, the names of the columns and the row's cells.
    """
    path, (number, names, row) = str(file), numbered
    if len(row) != len(names):
        where = f"row {number} ({row[0].strip()[:40]}), number of cells"
        expected = f"{len(names)}, as in the header"
        remedy = DECIMAL_POINT_REMEDY if len(row) > len(names) else ""
        findings.append(InputIssue(path, where, str(len(row)), expected, remedy))
        return None
    cells = {n: cell.strip() for n, cell in zip(names, row, strict=True) if cell.strip()}
    if "source" in cells:
        cells["source"] = with_slash_after_folders(root, cells["source"])
    try:
        trial = Trial.model_validate(cells)
    except ValidationError as error:
        place = f"row {number} ({cells.get('trial_id', '?')[:40]})"
        findings.extend(issues_of_refused_values(path, error, Trial, prefix=place))
        return None
    findings.extend(_path_findings(path, f"row {number} ({trial.trial_id})", trial))
    return trial


def _path_findings(path: str, row: str, trial: Trial) -> list[InputIssue]:
    named = [*(("source", s) for s in trial.sources), ("motor_log", trial.motor_log or "")]
    found = [
        InputIssue(
            path,
            f"{row}, {column}",
            repr(name),
            EXPECTED_PATH_WITHOUT_NUL_TEXT if "\0" in name else EXPECTED_PATH_TEXT,
        )
        for column, name in named
        if ".." in Path(name).parts or "\0" in name
    ]
    known = {*VIDEO_SUFFIXES, *KEYPOINT_SUFFIXES}
    films = [name for name in trial.sources if not is_image_source(name)]
    if not trial.sources or not {Path(name).suffix.lower() for name in films} <= known:
        expected = f"a video or keypoint file ({', '.join(sorted(known))}), or pictures: a folder "
        expected += "or a pattern such as T01/*.png"
        found.append(InputIssue(path, f"{row}, source", repr(trial.source), expected))
    elif films and len(films) < len(trial.sources):
        found.append(InputIssue(path, f"{row}, source", repr(trial.source), "videos or pictures"))
    elif trial.reads_keypoints and len(trial.sources) > 1:
        found.append(InputIssue(path, f"{row}, source", repr(trial.source), "one keypoint file"))
    return found


def _duplicate_id_findings(path: str, ids: list[tuple[int, str]]) -> list[InputIssue]:
    """Each trial_id that stands in several rows. ids: row number and trial_id."""
    rows_of: dict[str, list[int]] = {}
    for number, name in ids:
        rows_of.setdefault(name.casefold(), []).append(number)
    again = {name for _, name in ids if len(rows_of[name.casefold()]) > 1}
    expected = "each trial_id once (upper and lower case count as the same)"
    return [
        InputIssue(
            path,
            "trial_id",
            f"'{name}' {len(rows)} times (rows {', '.join(map(str, rows))})",
            expected,
        )
        for name in sorted(again)
        for rows in [rows_of[name.casefold()]]
    ]
