"""Validation errors as findings: file, row or key, what was found, what was expected, the
remedy.
"""

from __future__ import annotations

import re
import reprlib
from datetime import date
from typing import Any

from pydantic import BaseModel, ValidationError

from ..errors import InputIssue, did_you_mean
from .consistency_rules import INCONSISTENT_VALUES_ERROR_TYPE, length_unit_remedy

EMPTY_KEY_REMEDIES = {
    "camera.pool_corners_px": "`bluekoi pool STUDY` draws a frame with ruled lines, from which to "
    "read four [u, v]."
}
"""Key of study.yaml that is empty -> where its value comes from."""
DECIMAL_POINT_REMEDY = "Decimals are written with a point: 29.97, not 29,97."
EXCHANGED_COLUMNS_REMEDY = "Are the columns power_pct and head_angle_deg exchanged?"
DECIMAL_COMMA_PATTERN = re.compile(r"\s*[-+]?\d+,\d+\s*")
_SHORT_REPR = reprlib.Repr()
_SHORT_REPR.maxstring = _SHORT_REPR.maxother = 110
_SHORT_REPR.maxlevel = 3


def issues_of_refused_values(
    path: str, error: ValidationError, model: type[BaseModel], *, prefix: str = ""
) -> list[InputIssue]:
    """One issue for each value that pydantic refused, in the order of the file."""
    items = [dict(item) for item in error.errors(include_url=False)]
    return [issue for item in items for issue in _issues_from_item(path, model, item, prefix)]


def _issues_from_item(
    path: str, model: type[BaseModel], item: dict[str, Any], prefix: str
) -> list[InputIssue]:
    if item["type"] != INCONSISTENT_VALUES_ERROR_TYPE:
        return [_issue_from_item(path, model, item, prefix)]
    section = ".".join(map(str, item["loc"]))
    return [
        InputIssue(
            path,
            ", ".join(filter(None, [prefix, f"{section}.{one.key}".lstrip(".")])),
            one.found,
            one.expected,
            one.remedy,
        )
        for one in item["ctx"]["problems"]
    ]


def _issue_from_item(
    path: str, model: type[BaseModel], item: dict[str, Any], prefix: str
) -> InputIssue:
    location = item["loc"]
    where = ", ".join(filter(None, [prefix, ".".join(map(str, location))]))
    if item["type"] == "extra_forbidden":
        remedy = did_you_mean(str(location[-1]), _keys_of_same_section(model, location[:-1]))
        return InputIssue(path, where, "an unknown key", "a known key", remedy)
    if item["type"] == "invalid_key":
        return InputIssue(
            path,
            where,
            f"the key {shortened_repr(item['input'])}",
            "a name before each colon",
            _numeric_key_remedy(item["input"]),
        )
    if item["type"] == "missing":
        thing = "an entry here" if isinstance(location[-1], int) else "this key, which is required"
        return InputIssue(path, where, "nothing", thing)
    if item["input"] is None:
        remedy = EMPTY_KEY_REMEDIES.get(where, "")
        return InputIssue(path, where, "nothing", _expected_text(item), remedy)
    return InputIssue(
        path, where, shortened_repr(item["input"]), _expected_text(item), _remedy(item)
    )


def _numeric_key_remedy(key: object) -> str:
    """For a number as a key, as the end of a number with a decimal comma is in braces."""
    is_number = isinstance(key, int | float) and not isinstance(key, bool)
    return DECIMAL_POINT_REMEDY if is_number else ""


def _remedy(item: dict[str, Any]) -> str:
    """What a value of this kind is usually due to, where that is known."""
    value = item["input"]
    if isinstance(value, str) and DECIMAL_COMMA_PATTERN.fullmatch(value):
        return DECIMAL_POINT_REMEDY
    if item["type"] == "less_than_equal" and item["loc"] == ("head_length_m",):
        return length_unit_remedy("head_length_m", float(value), 1.0)
    is_power = item["type"] == "greater_than_equal" and item["loc"] == ("power_pct",)
    return EXCHANGED_COLUMNS_REMEDY if is_power and float(value) < 0 else ""  # not for a NaN


def _expected_text(item: dict[str, Any]) -> str:
    """What would have been right, in the words of a yaml file rather than Python's."""
    limits = item.get("ctx", {})
    if item["type"] in ("too_long", "too_short"):
        count = limits.get("max_length", limits.get("min_length"))
        return f"{count} entries, not {limits.get('actual_length')}"
    if item["type"] in ("model_type", "dict_type", "model_attributes_type"):
        return "keys with values below it"
    if item["type"] in ("float_parsing", "float_type", "int_parsing", "int_type"):
        return "a number"
    if item["type"] == "tuple_type":
        return "a list in brackets"
    return str(item["msg"]).removeprefix("Value error, ").removeprefix("Input should be ")


def _keys_of_same_section(model: type[BaseModel], location: tuple[Any, ...]) -> list[str]:
    for key in location:
        section = model.model_fields.get(str(key))
        annotation = section.annotation if section else None
        if not (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
            break
        model = annotation
    return list(model.model_fields)


def shortened_repr(value: Any) -> str:
    """`value` as Python writes it, cut short; a date as yaml writes it."""
    if isinstance(value, date):
        return f"the date {value.isoformat()}"
    return _SHORT_REPR.repr(value)
