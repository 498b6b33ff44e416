"""Values that the set-up page sends, checked: texts, numbers, a draft."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from ..errors import InputError, input_error
from ..study.validation_messages import shortened_repr
from .draft import Draft


def parse_request(body: bytes) -> dict[str, Any]:
    """The JSON object in the body of a request. Raises: InputError for any other content."""
    try:
        content = json.loads(body)
    except (ValueError, RecursionError) as error:
        deep = isinstance(error, RecursionError)
        found = "brackets nested too deeply" if deep else "no readable json"
        raise input_error("request", "", found, "a json object") from error
    if not isinstance(content, dict):
        raise input_error("request", "", type(content).__name__, "a json object")
    return content


def draft_from_request(content: Mapping[str, Any]) -> Draft:
    """The draft that the page sent. Raises: InputError where values or rows are missing."""
    return Draft(
        validated_text_mapping(content.get("values"), "values"), rows_from_request(content), (),
        str(content.get("revision") or ""),
    )  # fmt: skip


def rows_from_request(content: Mapping[str, Any]) -> list[dict[str, str]]:
    """Rows of trials.csv that the page sent. Raises: InputError where it sent none."""
    rows = content.get("rows")
    if not isinstance(rows, list):
        raise _request_error(rows, "rows", "a list of rows of trials.csv")
    return [validated_text_mapping(row, f"rows[{n}]") for n, row in enumerate(rows)]


def validated_text_mapping(value: Any, place: str) -> dict[str, str]:
    """A mapping of names to texts. Raises: InputError where `value` is something else."""
    if not isinstance(value, dict):
        raise _request_error(value, place, "texts by name")
    for name, text in value.items():
        if not isinstance(text, str):
            raise _request_error(text, f"{place}, {name}", "a text")
    return dict(value)


def finite_number(value: Any, place: str) -> float:
    """A finite number. Raises: InputError where `value` is something else."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise _request_error(value, place, "a finite number")
    return number


def _request_error(value: Any, place: str, expected: str) -> InputError:
    found = "nothing" if value is None else shortened_repr(value)
    return input_error("request", place, found, expected)
