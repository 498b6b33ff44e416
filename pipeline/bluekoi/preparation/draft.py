"""study.yaml and trials.csv as text to edit: read, checked, and saved whole with comments kept."""

from __future__ import annotations

import csv
import hashlib
import io
import shutil
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import yaml
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.error import YAMLError

from ..errors import input_error, unreadable_reason
from ..files import atomic_write, read_text
from ..study.key_reference import setting_keys
from .commented_keys import with_commented_keys_in_place
from .prefill import blank_study_yaml, prefilled_trial_rows, study_files, trials_csv

STUDY_FILES = ("study.yaml", "trials.csv")
"""Files of a study, in the order of their texts."""
FILE_LEFT_UNCHANGED_REMEDY = "Mend it in an editor; it was left as it is."
BACKUP_FOLDER = ".backup"
"""Folder in the study to which a file is copied before it is changed."""
REQUIRED_KEYS = {key.name for key in setting_keys() if key.default == "required"}
"""Keys and columns that a study must have."""
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
    content = _yaml_document(folder, texts[0])
    header, rows = _trials_table(folder, texts[1])
    if texts[1] is None:
        rows = prefilled_trial_rows(study_files(folder))
    return Draft(_flattened_values(content), rows, header, _revision_hash(texts))


def save_draft(draft: Draft, folder: Path) -> tuple[Draft, list[str]]:
    """Both files written, comments and the order of keys kept; the new draft, and what was done.

    A file that says the same already is left alone; of one that is replaced a copy is kept in the
    folder `.backup`.

    Raises: InputError where a file was changed by others since it was read, or cannot be written;
    then neither file is changed.
    """
    texts = study_file_texts(folder)
    if draft.revision and draft.revision != _revision_hash(texts):
        raise input_error(
            folder, "", "study.yaml or trials.csv was changed by another program since the page "
            "read it", "files as the page read them", "Reload the page to see the changes; nothing "
            "was saved.",
        )  # fmt: skip
    wanted = edited_texts(draft, folder, texts)
    changed = [
        (name, old, new)
        for name, old, new in zip(STUDY_FILES, texts, wanted, strict=True)
        if old is None or old != new
    ]
    with ExitStack() as files:
        for name, old, new in changed:
            target = (folder / name).resolve()
            if old is not None:
                _back_up(target, folder / BACKUP_FOLDER)
            files.enter_context(atomic_write(target)).write_text(new, encoding="utf-8")
    done = [f"{name} {'saved' if old is None else 'changed'}" for name, old, _ in changed]
    return read_draft(folder), done


def _back_up(path: Path, folder: Path) -> None:
    """A copy of a file, named after the moment."""
    folder.mkdir(exist_ok=True)
    stamp = datetime.now().strftime("%Y%m%d-%H%M%S-%f")
    shutil.copy2(path, folder / f"{path.stem}-{stamp}{path.suffix}")


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


def _revision_hash(texts: Sequence[str | None]) -> str:
    return hashlib.sha256(repr(texts).encode()).hexdigest()


def _round_trip_yaml() -> YAML:
    """Reader and writer that keeps comments, order and quotes."""
    round_trip = YAML(typ="rt")
    round_trip.preserve_quotes = True
    round_trip.width = 4096
    return round_trip


def _yaml_document(folder: Path, text: str | None) -> CommentedMap:
    """study.yaml with its comments; the blank one where there is none."""
    try:
        content = _round_trip_yaml().load(blank_study_yaml() if text is None else text)
    except (YAMLError, ValueError, RecursionError) as error:
        found = f"no readable yaml ({unreadable_reason(error)})"
        raise input_error(
            folder / STUDY_FILES[0], "", found, "yaml", FILE_LEFT_UNCHANGED_REMEDY
        ) from error
    if content is None:
        content = _round_trip_yaml().load(blank_study_yaml())
    if not isinstance(content, CommentedMap):
        raise input_error(folder / STUDY_FILES[0], "", "no keys",
                          "keys pool, robot, camera and others",
                          FILE_LEFT_UNCHANGED_REMEDY)  # fmt: skip
    return content


def _trials_table(folder: Path, text: str | None) -> tuple[list[str], list[dict[str, str]]]:
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


def _flattened_values(content: Mapping[str, Any]) -> dict[str, str]:
    """Dotted key to text, of the sections' keys and of keys without a section."""
    found: dict[str, str] = {}
    for name, value in content.items():
        if isinstance(value, Mapping) and name != "bodyparts":
            found |= {f"{name}.{key}": _value_as_text(entry) for key, entry in value.items()}
        else:
            found[str(name)] = _value_as_text(value)
    return {key: text for key, text in found.items() if text}


def _value_as_text(value: Any) -> str:
    """A value as a person types it: plain text, or a list or mapping in flow style."""
    if value is None:
        return ""
    if isinstance(value, str):
        return str(value)
    text = yaml.safe_dump(
        _builtin_types(value), default_flow_style=True, width=100_000, sort_keys=False
    )
    return text.removesuffix("\n").removesuffix("\n...").strip()


def _builtin_types(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _builtin_types(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_builtin_types(entry) for entry in value]
    if isinstance(value, bool) or value is None:
        return value
    if isinstance(value, (int, float)):
        return int(value) if isinstance(value, int) else float(value)
    return str(value)


def edited_texts(
    draft: Draft, folder: Path, texts: tuple[str | None, str | None]
) -> tuple[str, str]:
    """Texts of both files with what the draft says."""
    given = [name for name, value in draft.values.items() if value.strip()]
    whole = blank_study_yaml() if texts[0] is None else texts[0]
    content = _yaml_document(folder, with_commented_keys_in_place(whole, given))
    edited = _update_document(content, draft.values)
    study = texts[0]
    if edited or study is None:
        out = io.StringIO()
        _round_trip_yaml().dump(content, out)
        study = out.getvalue()
    header, rows = _trials_table(folder, texts[1])
    same = texts[1] is not None and [_nonempty_cells(r) for r in rows] == [
        _nonempty_cells(r) for r in draft.rows
    ]
    trials = texts[1] if same else trials_csv(draft.rows, header)
    assert trials is not None
    return study, trials


def _nonempty_cells(row: Mapping[str, str]) -> dict[str, str]:
    """Cells of a row that say something."""
    return {name: " ".join(text.split()) for name, text in row.items() if text.strip()}


def _update_document(content: CommentedMap, values: Mapping[str, str]) -> bool:
    """Whether anything in the document had to be changed to say what `values` say."""
    before = _flattened_values(content)
    given = {name: text.strip() for name, text in values.items() if text.strip()}
    for name in before.keys() - given.keys():
        section, _, key = name.partition(".")
        parent = content[section] if key else content
        if name in REQUIRED_KEYS:
            parent[key or section] = None
        else:
            _delete_entry(parent, key or section)
            if key and not parent:
                _delete_entry(content, section)
    changed = {name: text for name, text in given.items() if before.get(name) != text}
    for name, text in changed.items():
        section, _, key = name.partition(".")
        if key and not isinstance(content.get(section), CommentedMap):
            content[section] = CommentedMap()
        _set_entry(content[section] if key else content, key or section, _parse_typed_text(text))
    return bool(changed or before.keys() - given.keys())


def _set_entry(parent: Any, key: Any, value: Any) -> None:
    """Set an entry; a list of the same length item by item: comments hang on its items."""
    known = parent[key] if not isinstance(parent, CommentedMap) or key in parent else None
    if isinstance(known, CommentedSeq) and isinstance(value, list) and len(known) == len(value):
        for i, item in enumerate(value):
            _set_entry(known, i, item)
    else:
        parent[key] = value


def _delete_entry(parent: CommentedMap, key: str) -> None:
    """Delete an entry; the comment behind it, that of the next one, goes to the one before."""
    before = list(parent)[: list(parent).index(key)]
    tokens = parent.ca.items.pop(key, None)
    del parent[key]
    if not (tokens and tokens[2] and before):
        return
    kept = parent.ca.items.setdefault(before[-1], [None, None, None, None])
    if kept[2]:
        kept[2].value += (
            tokens[2].value.lstrip("\n") if kept[2].value.endswith("\n") else tokens[2].value
        )
    else:
        kept[2] = tokens[2]


def _parse_typed_text(text: str) -> Any:
    """Value of a text as typed: a number, a list, a mapping; else the text itself."""
    try:
        value = yaml.safe_load(text)
    except (yaml.YAMLError, RecursionError):
        return text
    if isinstance(value, (list, dict)):
        flow = _round_trip_yaml().load(text)
        if isinstance(flow, (CommentedSeq, CommentedMap)):
            flow.fa.set_flow_style()
        return flow
    return value if isinstance(value, (int, float)) and not isinstance(value, bool) else text
