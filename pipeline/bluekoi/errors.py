"""Errors of the input, each with place, found, expected and remedy."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

EXIT_USAGE = 2
"""An option or argument that the command does not have."""
EXIT_INTERRUPTED = 130
"""Exit code of a command that was interrupted from the keyboard."""
MIN_ROWS_TO_MERGE_ISSUES = 4
"""The same finding in as many rows of a table or more is shown as one line."""
FINDING_ROW_PATTERN = re.compile(r"row (\d+) \(([^()]*)\), (.+)")
"""Place of a finding in a row: its number, the trial, the column."""
INTERRUPTED_MESSAGE = "Interrupted. What is done is kept; start again and it goes on."


@dataclass(frozen=True)
class InputIssue:
    """One thing wrong at one place: file, row or key, what was found, what was expected."""

    file: str
    where: str
    found: str
    expected: str
    remedy: str = ""

    def __str__(self) -> str:
        place = f"{self.file}: {self.where}" if self.where else self.file
        remedy = f" {self.remedy}" if self.remedy else ""
        return f"{place}: found {self.found}; expected {self.expected}.{remedy}"


class InputError(Exception):
    """A user's mistake or a broken input; its text is the whole message, shown without a traceback.

    Carries one or more `findings`, all of which are shown at once.

        >>> try:
        ...     load_study("no_such_lab")
        ... except InputError as error:
        ...     print(error)
        no_such_lab: found no such folder; expected a study folder with study.yaml and trials.csv.
    """

    def __init__(self, findings: InputIssue | Iterable[InputIssue]) -> None:
        self.findings: tuple[InputIssue, ...] = (
            (findings,) if isinstance(findings, InputIssue) else tuple(findings)
        )
        shown = _without_repeated_remedies(_merge_row_findings(self.findings))
        super().__init__("\n".join(map(str, shown)))

    def __reduce__(self) -> tuple[type[InputError], tuple[tuple[InputIssue, ...]]]:
        """Carry the findings, not their text, to another process."""
        return type(self), (self.findings,)


def _without_repeated_remedies(findings: Iterable[InputIssue]) -> Iterator[InputIssue]:
    """Findings of which the first one with a remedy keeps it."""
    seen: set[str] = set()
    for finding in findings:
        yield replace(finding, remedy="") if finding.remedy in seen else finding
        seen.add(finding.remedy)


def _merge_row_findings(findings: Iterable[InputIssue]) -> list[InputIssue]:
    """Findings that differ in the row of a table alone made one, at the place of the first."""
    groups: dict[object, list[InputIssue]] = {}
    for finding in findings:
        row = FINDING_ROW_PATTERN.fullmatch(finding.where)
        groups.setdefault(replace(finding, where=row[3]) if row else finding, []).append(finding)
    return [
        one
        for same in groups.values()
        for one in (same if len(same) < MIN_ROWS_TO_MERGE_ISSUES else [_merged_row_finding(same)])
    ]


def _merged_row_finding(same: list[InputIssue]) -> InputIssue:
    """One finding for all the rows that `same` stand for."""
    rows = [row for one in same if (row := FINDING_ROW_PATTERN.fullmatch(one.where))]
    if not rows:
        return same[0]
    first, last = rows[0], rows[-1]
    unbroken = int(last[1]) - int(first[1]) == len(rows) - 1
    numbers = f"rows {first[1]} to {last[1]}" if unbroken else f"{len(rows)} rows"
    return replace(same[0], where=f"{numbers} ({first[2]} to {last[2]}), {first[3]}")


def input_error(
    file: object, where: str, found: object, expected: str, remedy: str = ""
) -> InputError:
    """A `InputError` with one finding, to be raised by the caller."""
    return InputError(InputIssue(str(file), where, str(found), expected, remedy))


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """A sentence naming the known name closest to `name`, or listing all when none is close."""
    names = sorted(known)
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    return f"Did you mean '{close[0]}'?" if close else f"Known: {', '.join(names)}."


def unreadable_reason(error: Exception) -> str:
    """Why a text file could not be parsed, without words that only a programmer understands."""
    if isinstance(error, UnicodeDecodeError):
        return f"byte {error.start + 1} is not UTF-8"
    if isinstance(error, RecursionError):
        return "brackets nested too deeply"
    if isinstance(error, ValueError) and "integer string conversion" in str(error):
        return "a number of thousands of digits"
    if isinstance(error, ValueError) and "must be in" in str(error):
        return f"a date that does not exist: {error}"
    return " ".join(str(error).replace('in "<unicode string>", ', "in ").split())


def escape_control_characters(text: str) -> str:
    """`text` with the control characters of hostile input made harmless for a terminal."""
    lines = text.splitlines()
    return "\n".join("".join(c if c.isprintable() else "?" for c in line) for line in lines)
