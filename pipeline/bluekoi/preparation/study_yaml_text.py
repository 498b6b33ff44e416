"""study.yaml as text to edit: values by dotted key, changed with comments and formatting kept."""

from __future__ import annotations

import io
import re
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.error import YAMLError
from ruamel.yaml.nodes import MappingNode, Node, SequenceNode

from ..errors import input_error, unreadable_reason
from ..study.key_reference import setting_keys
from .commented_keys import with_commented_keys_in_place
from .format_preserving_edit import with_unedited_lines_restored
from .prefill import blank_study_yaml

STUDY_YAML = "study.yaml"
FILE_LEFT_UNCHANGED_REMEDY = "Mend it in an editor; it was left as it is."
REQUIRED_KEYS = {key.name for key in setting_keys() if key.default == "required"}
"""Keys and columns that a study must have."""


def yaml_document(folder: Path, text: str | None) -> CommentedMap:
    """study.yaml with its comments; without a text, the blank template."""
    try:
        content = _round_trip_yaml().load(blank_study_yaml() if text is None else text)
    except (YAMLError, ValueError, RecursionError) as error:
        found = f"no readable yaml ({unreadable_reason(error)})"
        raise input_error(
            folder / STUDY_YAML, "", found, "yaml", FILE_LEFT_UNCHANGED_REMEDY
        ) from error
    if content is None:
        content = _round_trip_yaml().load(f"{text}\n{blank_study_yaml()}".lstrip())
    if not isinstance(content, CommentedMap):
        raise input_error(folder / STUDY_YAML, "", "no keys",
                          "keys pool, robot, camera and others",
                          FILE_LEFT_UNCHANGED_REMEDY)  # fmt: skip
    return content


def flattened_values(content: Mapping[str, Any]) -> dict[str, str]:
    """Dotted key to text, of the sections' keys and of keys without a section."""
    found: dict[str, str] = {}
    for name, value in content.items():
        if isinstance(value, Mapping) and name != "bodyparts":
            found |= {f"{name}.{key}": _value_as_text(entry) for key, entry in value.items()}
        else:
            found[str(name)] = _value_as_text(value)
    return {key: text for key, text in found.items() if text}


def edited_study_yaml(folder: Path, text: str | None, values: Mapping[str, str]) -> str:
    """The text with `values` applied; unchanged lines keep their formatting.

    Raises: InputError where the text cannot be read as yaml.
    """
    given = {name: typed.strip() for name, typed in values.items() if typed.strip()}
    whole = blank_study_yaml() if text is None else text
    former = yaml_document(folder, whole)
    missing = flattened_values(former).keys() - given.keys()
    if not missing and not _changed_values(former, given):
        return whole
    emptied = (missing & REQUIRED_KEYS) | _keys_with_changed_list_length(former, given)
    whole = with_commented_keys_in_place(whole, given)
    whole = without_yaml_entries(whole, missing - REQUIRED_KEYS, emptied)
    content = yaml_document(folder, whole)
    plain = _document_as_text(content, whole)
    _update_document(content, given)
    edited = _document_as_text(content, whole)
    kept = with_unedited_lines_restored(whole, plain, edited)
    return kept if _has_same_content(kept, edited) else edited


def without_yaml_entries(text: str, names: Collection[str], emptied: Collection[str] = ()) -> str:
    """The text without the entries of `names` (`section.key`), and without the values of `emptied`.

    Comments above and below an entry stay, and that behind it; those inside it go. Entries in
    braces stay, unless they are all that their section has.
    """
    root = _round_trip_yaml().compose(text)
    if not isinstance(root, MappingNode) or root.flow_style:
        return text
    for begin, end in sorted(_spans_to_cut(text, root, names, emptied), reverse=True):
        first = text.rfind("\n", 0, begin) + 1
        last = text.find("\n", end) + 1 or len(text)
        line, rest = text[first:begin], text[end:last].strip()
        if rest.startswith("#"):
            line += f"  {rest}" if line.strip() else rest
        text = text[:first] + (f"{line.rstrip()}\n" if line.strip() else "") + text[last:]
    return text


def _spans_to_cut(
    text: str, root: MappingNode, names: Collection[str], emptied: Collection[str]
) -> Iterator[tuple[int, int]]:
    """Begin and end of what `without_yaml_entries` takes out; a section without entries goes
    too.
    """
    for key, value in root.value:
        section = isinstance(value, MappingNode) and key.value != "bodyparts"
        entries = value.value if section else []
        named = {f"{key.value}.{entry[0].value}": entry for entry in entries}
        gone = bool(entries) and named.keys() <= set(names)
        if key.value in names or (gone and value.flow_style):
            yield key.start_mark.index, _entry_end(text, key, value)
        elif not section and key.value in emptied:
            yield _index_after_colon(text, key), _entry_end(text, key, value)
        elif entries and not value.flow_style:
            for name, (inner, entry) in named.items():
                end = _entry_end(text, inner, entry)
                if name in names:
                    yield inner.start_mark.index, end
                elif name in emptied:
                    yield _index_after_colon(text, inner), end
            if gone:
                yield key.start_mark.index, _index_after_colon(text, key)


def _index_after_colon(text: str, key: Node) -> int:
    return text.index(":", key.end_mark.index) + 1


def _entry_end(text: str, key: Node, value: Node) -> int:
    """Where an entry ends, without the comment behind it."""
    return len(text[: max(_index_after_colon(text, key), _value_end_index(value))].rstrip())


def _value_end_index(node: Node) -> int:
    """Where a value ends; a list on several lines ends with its last item."""
    if isinstance(node, (MappingNode, SequenceNode)) and not node.flow_style:
        last = node.value[-1]
        return _value_end_index(last[1] if isinstance(last, tuple) else last)
    return int(node.end_mark.index)


def _round_trip_yaml() -> YAML:
    """Reader and writer that keeps comments, order and quotes."""
    round_trip = YAML(typ="rt")
    round_trip.preserve_quotes = True
    round_trip.width = 4096
    return round_trip


def _document_as_text(content: CommentedMap, like: str) -> str:
    """Text of a document, its keys indented as those of another text."""
    out, writer = io.StringIO(), _round_trip_yaml()
    indent = re.search(r"^( +)\w+:", like, re.MULTILINE)
    writer.indent(mapping=len(indent[1]) if indent else 2)
    writer.dump(content, out)
    return out.getvalue()


def _has_same_content(text: str, other: str) -> bool:
    """Whether two texts of study.yaml have the same content."""
    try:
        first, second = (_as_builtin_types(_round_trip_yaml().load(one)) for one in (text, other))
    except YAMLError:
        return False
    return bool(first == second)


def _value_as_text(value: Any) -> str:
    """A value as a person types it: plain text, or a list or mapping in flow style."""
    if value is None:
        return ""
    if isinstance(value, str):
        return str(value)
    text = yaml.safe_dump(
        _as_builtin_types(value), default_flow_style=True, width=100_000, sort_keys=False
    )
    return text.removesuffix("\n").removesuffix("\n...").strip()


def _as_builtin_types(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _as_builtin_types(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_as_builtin_types(entry) for entry in value]
    if isinstance(value, bool) or value is None:
        return value
    if isinstance(value, (int, float)):
        return int(value) if isinstance(value, int) else float(value)
    return str(value)


def _changed_values(content: CommentedMap, given: Mapping[str, str]) -> dict[str, str]:
    """Those of `given` that differ from the document."""
    before = flattened_values(content)
    return {name: text for name, text in given.items() if before.get(name) != text}


def _keys_with_changed_list_length(content: CommentedMap, given: Mapping[str, str]) -> set[str]:
    """Keys with a list or mapping in whose place something else comes than a list as long."""
    found = set()
    for name, text in _changed_values(content, given).items():
        section, _, key = name.partition(".")
        parent = content.get(section) if key else content
        old = parent.get(key or section) if isinstance(parent, CommentedMap) else None
        new = _parse_typed_text(text)
        if isinstance(old, CommentedMap) or (
            isinstance(old, CommentedSeq) and not (isinstance(new, list) and len(new) == len(old))
        ):
            found.add(name)
    return found


def _update_document(content: CommentedMap, given: Mapping[str, str]) -> None:
    """Apply `given` to the document; a required key without a value stays, empty."""
    for name in flattened_values(content).keys() - given.keys():
        section, _, key = name.partition(".")
        parent = content[section] if key else content
        if name in REQUIRED_KEYS:
            parent[key or section] = None
        else:
            del parent[key or section]
            if key and not parent:
                del content[section]
    for name, text in _changed_values(content, given).items():
        section, _, key = name.partition(".")
        if key and not isinstance(content.get(section), CommentedMap):
            content[section] = CommentedMap()
        _set_entry(content[section] if key else content, key or section, _parse_typed_text(text))


def _set_entry(parent: Any, key: Any, value: Any) -> None:
    """Set an entry; a list of the same length item by item: comments hang on its items."""
    known = parent[key] if not isinstance(parent, CommentedMap) or key in parent else None
    if isinstance(known, CommentedSeq) and isinstance(value, list) and len(known) == len(value):
        for i, item in enumerate(value):
            _set_entry(known, i, item)
    else:
        parent[key] = value


def _parse_typed_text(text: str) -> Any:
    """Value of a text as typed: a number, a list, a mapping; else the text itself."""
    try:
        value = yaml.safe_load(text)
        flow = _round_trip_yaml().load(text) if isinstance(value, (list, dict)) else None
    except (yaml.YAMLError, YAMLError, ValueError, RecursionError):
        return text
    if isinstance(flow, (CommentedSeq, CommentedMap)):
        flow.fa.set_flow_style()
        return flow
    return value if isinstance(value, (int, float)) and not isinstance(value, bool) else text
