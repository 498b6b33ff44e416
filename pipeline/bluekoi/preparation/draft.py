"""study.yaml and trials.csv as text to edit: read, and written with what a draft says."""

from __future__ import annotations

import csv
import hashlib
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import input_error, unreadable_reason
from ..files import read_text
from .prefill import prefilled_trial_rows, trials_csv_text, usable_study_files
from .study_yaml_text import (
    FILE_LEFT_UNCHANGED_REMEDY,
    STUDY_YAML,
    edited_study_yaml,
    flattened_values,
    yaml_document,
)

STUDY_FILES = (STUDY_YAML, "trials.csv")
"""Files of a study, in the order of their texts."""
MAX_FILE_BYTES = 10_000_000


@dataclass(frozen=True)
class Draft:
    """What a study's two files say, as typed.

    values: dotted key of study.yaml to text, lists in yaml's flow style; keys without a value are
    left out. rows: a row of trials.csv each, column to text. header: columns of the file. revision:
    hash of both files as read, by which a change by others is noticed.
    """

    values: Mapping[str, str]
    rows: Sequence[Mapping[str, str]]
    header: Sequence[str] = ()
    revision: str = ""


def read_draft(folder: Path) -> Draft:
    """Draft of a study folder; pre-filled from its files where study.yaml or trials.csv is missing.

    Raises: InputError where a file is there and cannot be read as yaml or csv.
    """
    texts = study_file_texts(folder)
    content = yaml_document(folder, texts[0])
    header, rows = trials_table(folder, texts[1])
    if texts[1] is None:
        rows = prefilled_trial_rows(usable_study_files(folder)[0])
    return Draft(flattened_values(content), rows, header, revision_hash(texts))


def study_file_texts(folder: Path) -> tuple[str | None, str | None]:
    """Text of both files; None where one is not there."""

    def text(name: str) -> str | None:
        try:
            return read_text(folder / name, MAX_FILE_BYTES)
        except FileNotFoundError:
            return None
        except (OSError, UnicodeDecodeError) as error:
            raise input_error(folder / name, "", f"no readable text ({error})", "a file in UTF-8",
                              FILE_LEFT_UNCHANGED_REMEDY) from error  # fmt: skip

    return text(STUDY_FILES[0]), text(STUDY_FILES[1])


def revision_hash(texts: Sequence[str | None]) -> str:
    """Hash of both texts, by which a change of one is noticed."""
    return hashlib.sha256(repr(texts).encode()).hexdigest()


def trials_table(folder: Path, text: str | None) -> tuple[list[str], list[dict[str, str]]]:
    """Header and rows of trials.csv."""
    if text is None:
        return [], []
    try:
        lines = [
            row for row in csv.reader(io.StringIO(text, newline="")) if any(map(str.strip, row))
        ]
    except csv.Error as error:
        found = f"no readable csv ({unreadable_reason(error)})"
        raise input_error(
            folder / STUDY_FILES[1], "", found, "a csv file", FILE_LEFT_UNCHANGED_REMEDY
        ) from error
    header = [cell.strip() for cell in lines[0]] if lines else []
    if len(set(header)) < len(header) or any(len(row) > len(header) for row in lines):
        raise input_error(folder / STUDY_FILES[1], "",
                          "a column twice, or a row longer than the header",
                          "a column for each cell",
                          FILE_LEFT_UNCHANGED_REMEDY)  # fmt: skip
    rows = [dict(zip(header, map(str.strip, row), strict=False)) for row in lines[1:]]
    return header, rows


def texts_with_draft_applied(
    draft: Draft, folder: Path, texts: tuple[str | None, str | None]
) -> tuple[str, str]:
    """Texts of both files with what the draft says."""
    study = edited_study_yaml(folder, texts[0], draft.values)
    header, rows = trials_table(folder, texts[1])
    same = texts[1] is not None and [_nonempty_cells(r) for r in rows] == [
        _nonempty_cells(r) for r in draft.rows
    ]
    trials = texts[1] if same else trials_csv_text(draft.rows, header)
    assert trials is not None
    return study, trials


def _nonempty_cells(row: Mapping[str, str]) -> dict[str, str]:
    """Cells of a row that say something."""
    return {name: " ".join(text.split()) for name, text in row.items() if text.strip()}
