"""What `bluekoi check` would find wrong in a draft, each beside its field; nothing is written."""

from __future__ import annotations

import re
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

from ..errors import InputError, InputIssue
from ..study import Study, StudySettings, missing_files
from ..study.key_reference import setting_keys
from ..study.study_yaml import read_study_settings
from ..study.trials_csv import read_trials
from .draft import STUDY_FILES, Draft, study_file_texts, texts_with_draft_applied
from .input_check import file_findings, setup_findings

STUDY_SECTIONS = {
    key.name for key in setting_keys() if "." not in key.name and key.file == STUDY_FILES[0]
}
"""Sections of study.yaml."""


@dataclass(frozen=True)
class DraftFinding:
    """A finding with its place on the page: a key of study.yaml, or row (from 0) and column."""

    text: str
    key: str = ""
    row: int | None = None
    column: str = ""


def draft_findings(draft: Draft, folder: Path, *, files: bool = False) -> list[DraftFinding]:
    """All that `bluekoi check` would find wrong if the draft were saved; nothing is written.

    files: also open every recording, keypoint file and motor log.
    """
    setup, study, findings = _validate_draft(draft, folder)
    if setup is not None and not findings:
        wrong, _ = setup_findings(setup, folder)
        findings += wrong
        if files and not wrong:
            findings += file_findings(study)
    return [_with_page_position(finding, draft, folder) for finding in findings]


def study_from_draft(draft: Draft, folder: Path) -> Study:
    """The study that the draft describes. Raises: InputError with all that is wrong in it."""
    setup, study, findings = _validate_draft(draft, folder)
    if findings or setup is None:
        raise InputError(findings)
    return study


def _validate_draft(
    draft: Draft, folder: Path
) -> tuple[StudySettings | None, Study, list[InputIssue]]:
    """Setup, study and findings of the draft, by the readers that every command uses."""
    findings: list[InputIssue] = []
    with tempfile.TemporaryDirectory() as name:
        texts = texts_with_draft_applied(draft, folder, study_file_texts(folder))
        for file, text in zip(STUDY_FILES, texts, strict=True):
            (Path(name) / file).write_text(text, encoding="utf-8")
        setup = read_study_settings(Path(name) / STUDY_FILES[0], findings)
        trials = read_trials(Path(name) / STUDY_FILES[1], findings, root=folder)
    findings = [replace(finding, file=Path(finding.file).name) for finding in findings]
    study = Study.model_construct(root=folder.resolve(), setup=setup, trials=tuple(trials))
    findings += missing_files(study)
    return setup, study, findings


def _with_page_position(finding: InputIssue, draft: Draft, folder: Path) -> DraftFinding:
    """A finding beside the field that it is about."""
    remedy = f" {finding.remedy}" if finding.remedy else ""
    text = f"found {finding.found}; expected {finding.expected}.{remedy}"
    file = Path(finding.file).name
    if file == STUDY_FILES[0]:
        known = [
            key.name
            for key in setting_keys()
            if key.name not in STUDY_SECTIONS or key.name == "bodyparts"
        ]
        place = next((k for k in known if f"{finding.where}.".startswith(f"{k}.")), "")
        return DraftFinding(text if place else f"{finding.where}: {text}", key=place)
    if file != STUDY_FILES[1]:
        return _with_row_of_file(finding, text, draft, folder)
    row = _row_index(finding.where, draft)
    column = finding.where.rpartition(", ")[2] if "," in finding.where else ""
    column = column if row is not None else ""
    if row is not None and not column and "no file '" in finding.found:
        named = finding.found.split("'")[1]
        column = "motor_log" if draft.rows[row].get("motor_log") == named else "source"
    return DraftFinding(text if row is not None else f"{finding.where}: {text}", "", row, column)


def _row_index(where: str, draft: Draft) -> int | None:
    """Row that a place in trials.csv names by its line or by its trial_id."""
    if line := re.match(r"row (\d+)", where):
        at = int(line[1]) - 2
        return at if 0 <= at < len(draft.rows) else None
    if named := re.match(r"trial ([A-Za-z0-9_-]+)", where):
        ids = [row.get("trial_id") for row in draft.rows]
        return ids.index(named[1]) if named[1] in ids else None
    return None


def _with_row_of_file(finding: InputIssue, text: str, draft: Draft, folder: Path) -> DraftFinding:
    """A finding on a recording, keypoint file or motor log beside the row that names it."""
    place = f"{finding.where}: " if finding.where else ""
    for at, row in enumerate(draft.rows):
        for column in ("source", "motor_log"):
            named = [part.strip() for part in row.get(column, "").split(";")]
            if any(part and Path(finding.file) == folder.resolve() / part for part in named):
                return DraftFinding(place + text, "", at, column)
    return DraftFinding(f"{finding.file}: {place}{text}")
