"""A draft saved: study.yaml and trials.csv both or neither, with a copy of what is replaced."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from ..errors import InputError, InputIssue, did_you_mean, input_error
from ..files import atomic_write
from ..study import Trial
from ..study.key_reference import setting_keys
from .draft import (
    STUDY_FILES,
    Draft,
    read_draft,
    revision_hash,
    study_file_texts,
    texts_with_draft_applied,
    trials_table,
)
from .study_yaml_text import flattened_values, yaml_document

BACKUP_FOLDER = ".backup"
"""Folder in the study to which a file is copied before it is changed."""
WRITE_REMEDY = "Make the folder writable, or free space; nothing was saved."


def save_draft(draft: Draft, folder: Path) -> tuple[Draft, list[str]]:
    """Both files written, comments and the order of keys kept; the new draft, and what was done.

    A file that says the same already is left alone; of one that is replaced a copy is kept in the
    folder `.backup`. The caller must not run two saves at once.

    Raises: InputError where a file was changed by others since it was read, the draft has a key or
    column that is unknown, or a file cannot be written; then neither file is changed.
    """
    if not folder.is_dir():
        raise input_error(folder, "", "no such folder", "the study folder that the page shows",
                          "It was moved or deleted; nothing was saved.")  # fmt: skip
    texts = study_file_texts(folder)
    _check_revision(draft, folder, texts)
    if unknown := _unknown_key_and_column_findings(draft, folder, texts):
        raise InputError(unknown)
    changed = [
        (name, old, new)
        for name, old, new in zip(
            STUDY_FILES, texts, texts_with_draft_applied(draft, folder, texts), strict=True
        )
        if old is None or old != new
    ]
    for name, old, _ in changed:
        if old is not None:
            _back_up((folder / name).resolve(), folder / BACKUP_FOLDER)
    _write_all([((folder / name).resolve(), new) for name, _, new in changed])
    done = [f"{name} {'saved' if old is None else 'changed'}" for name, old, _ in changed]
    return read_draft(folder), done


def _check_revision(draft: Draft, folder: Path, texts: Sequence[str | None]) -> None:
    """Refuse a draft that does not come from the files as they are now."""
    is_new = all(text is None for text in texts)
    if draft.revision == revision_hash(texts) or (is_new and not draft.revision):
        return
    found = (
        "study.yaml or trials.csv was changed by another program since the page read it"
        if draft.revision
        else "files of a study, and a draft that does not say which revision of them it changes"
    )
    raise input_error(
        folder, "", found, "files as the page read them",
        "Reload the page to see the changes; nothing was saved.",
    )  # fmt: skip


def _unknown_key_and_column_findings(
    draft: Draft, folder: Path, texts: tuple[str | None, str | None]
) -> list[InputIssue]:
    """A finding for each key and column of a draft that no study has, nor the files as they are."""
    names = {key.name for key in setting_keys() if key.file == STUDY_FILES[0]}
    keys = names - {name.partition(".")[0] for name in names if "." in name}
    present = flattened_values(yaml_document(folder, texts[0])).keys()
    header = trials_table(folder, texts[1])[0]
    columns = dict.fromkeys(name for row in draft.rows for name in row)
    return [
        *(_unknown_name_finding(STUDY_FILES[0], "key", name, keys)
          for name in draft.values if name not in keys | present),
        *(_unknown_name_finding(STUDY_FILES[1], "column", name, Trial.model_fields)
          for name in columns if name not in {*Trial.model_fields, *header}),
    ]  # fmt: skip


def _unknown_name_finding(file: str, kind: str, name: str, known: Iterable[str]) -> InputIssue:
    remedy = f"{did_you_mean(name, known)} Nothing was saved."
    return InputIssue(file, name, f"an unknown {kind}", f"a known {kind}", remedy)


def _back_up(path: Path, folder: Path) -> None:
    """A copy of a file, named after the moment. Raises: InputError where it cannot be written."""
    stamp = datetime.now().strftime("%Y%m%d-%H%M%S-%f")
    try:
        folder.mkdir(exist_ok=True)
        shutil.copy2(path, folder / f"{path.stem}-{stamp}{path.suffix}")
    except OSError as error:
        raise input_error(
            folder, "", f"'{error.strerror or error}' on copying {path.name}",
            "a folder for copies of what is replaced", WRITE_REMEDY,
        ) from error  # fmt: skip


def _write_all(texts: Sequence[tuple[Path, str]]) -> None:
    """All files written, or none. Raises: InputError where one cannot be written."""
    with ExitStack() as files:
        for path, _ in texts:
            files.enter_context(_restored_on_error(path))
        for path, text in texts:
            files.enter_context(_study_file_write(path)).write_text(text, encoding="utf-8")


@contextmanager
def _study_file_write(path: Path) -> Iterator[Path]:
    """`atomic_write` with a remedy that suits a study."""
    try:
        with atomic_write(path) as temporary:
            yield temporary
    except InputError as error:
        raise InputError([replace(one, remedy=WRITE_REMEDY) for one in error.findings]) from error


@contextmanager
def _restored_on_error(path: Path) -> Iterator[None]:
    """The file at a path as it was before, if the block ends with an error."""
    former = path.read_bytes() if path.exists() else None
    try:
        yield
    except Exception:
        try:
            if former is None and path.exists():
                path.unlink()
            elif former is not None and path.read_bytes() != former:
                with atomic_write(path) as temporary:
                    temporary.write_bytes(former)
        except (InputError, OSError) as error:
            raise input_error(
                path, "", "new content, while the other file could not be saved",
                "the former content", f"A copy of that is in {BACKUP_FOLDER}.",
            ) from error  # fmt: skip
        raise
