"""Every key of study.yaml and column of trials.csv: meaning, unit, default, allowed values.

Made from the fields in `setup` and `types`, for `bluekoi check --explain` and docs/study_keys.md.
"""

from __future__ import annotations

import typing
from collections.abc import Iterator
from dataclasses import dataclass
from types import UnionType
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from ..errors import did_you_mean, input_error
from .setup import StudySettings
from .types import Trial

SETTINGS_CLASS_BY_FILE: dict[str, type[BaseModel]] = {
    "study.yaml": StudySettings,
    "trials.csv": Trial,
}
"""File of a study -> model of its keys."""
LIMIT_PHRASES = {
    "gt": "more than {:g}",
    "ge": "at least {:g}",
    "lt": "less than {:g}",
    "le": "at most {:g}",
}
"""Constraint of a field -> how it is worded."""


@dataclass(frozen=True)
class SettingKey:
    """One key: its file, its dotted name there, meaning, unit, default and allowed values.

    default: `required`, or the value as yaml writes it; empty where leaving it out means unknown.
    """

    file: str
    name: str
    meaning: str
    unit: str
    default: str
    allowed: str

    def __str__(self) -> str:
        facts = {"unit": self.unit, "default": self.default, "allowed": self.allowed}
        lines = [f"  {name + ':':9}{value}" for name, value in facts.items() if value]
        return "\n".join([f"{self.name} ({self.file})", f"  {self.meaning}", *lines])


def setting_keys() -> list[SettingKey]:
    """All keys, sections before what stands in them."""
    return [
        key
        for file, model in SETTINGS_CLASS_BY_FILE.items()
        for key in _keys_of_settings_class(file, model, "")
    ]


def explain_key(name: str) -> str:
    """Text on a key, by its dotted or its bare name; on all keys of a section.

    Raises: InputError with the nearest name where there is no such key.
    """
    known = setting_keys()
    found = [k for k in known if name in (k.name, k.name.rpartition(".")[2])]
    inside = [k for k in known if k.name.startswith(f"{name}.")]
    if not found:
        names = {k.name for k in known} | {k.name.rpartition(".")[2] for k in known}
        raise input_error("--explain", "", f"'{name}'", "a known key", did_you_mean(name, names))
    return "\n".join(map(str, found + inside))


def _keys_of_settings_class(file: str, model: type[BaseModel], prefix: str) -> Iterator[SettingKey]:
    for name, field in model.model_fields.items():
        extra = typing.cast("dict[str, Any]", field.json_schema_extra)
        yield SettingKey(
            file=file,
            name=prefix + name,
            meaning=field.description or "",
            unit=str(extra["unit"]),
            default=_default_text(field),
            allowed=_allowed_values_text(field),
        )
        if isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel):
            yield from _keys_of_settings_class(file, field.annotation, f"{prefix}{name}.")


def _default_text(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    value = field.get_default(call_default_factory=True)
    return "" if value is None or value == {} or isinstance(value, BaseModel) else f"{value}"


def _allowed_values_text(field: FieldInfo) -> str:
    """Bounds or choices of a field, in words."""
    choices = [
        value
        for part in _union_members(field.annotation)
        if typing.get_origin(part) is typing.Literal
        for value in typing.get_args(part)
    ]
    if choices:
        return " or ".join(map(str, choices))
    metadata = [
        *field.metadata,
        *(
            m
            for part in _union_members(field.annotation)
            for m in getattr(part, "__metadata__", ())
        ),
    ]
    bounds = [m for one in metadata for m in (getattr(one, "metadata", None) or [one])]
    return ", ".join(
        text.format(value)
        for name, text in LIMIT_PHRASES.items()
        if (value := next((v for m in bounds if (v := getattr(m, name, None)) is not None), None))
        is not None
    )


def _union_members(annotation: Any) -> list[Any]:
    """The alternatives of a union, else the annotation itself."""
    union = typing.get_origin(annotation) in (typing.Union, UnionType)
    return list(typing.get_args(annotation)) if union else [annotation]
