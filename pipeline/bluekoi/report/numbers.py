"""Values, intervals and names formatted for readers."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any

from ..model import two_plate_system

Z_95 = 1.96
UNIT_SYMBOLS = {"m2": "m²", "kg m2": "kg m²", "kg_m2": "kg m²", "1": "–", "": "–"}
"""Unit as in the files -> unit as the report prints it."""


def format_number(value: Any, digits: int = 3) -> str:
    """A number with `digits` significant digits; a dash for None and NaN."""
    if value is None or not math.isfinite(float(value)):
        return "–"
    value = float(value)
    if value != 0 and not 1e-3 <= abs(value) < 1e5:
        mantissa, power = f"{value:.{digits - 1}e}".split("e")
        return f"{mantissa} × 10{_superscript(int(power))}"
    places = max(0, digits - 1 - math.floor(math.log10(abs(value)))) if value else 0
    return f"{value:.{places}f}"


def value_with_interval(value: Any, std: Any, unit: str = "") -> str:
    """Value ± half of the 95 % interval, with the digits that the interval justifies."""
    tail = f" {unit}" if unit and unit != "–" else ""
    if value is None or not math.isfinite(float(value)):
        return "–"
    if std is None or not math.isfinite(float(std)) or float(std) <= 0:
        return format_number(value) + tail
    value, half = float(value), Z_95 * float(std)
    power = math.floor(math.log10(max(abs(value), half))) if value else 0
    factor, mark = (
        (10.0**-power, f" × 10{_superscript(power)}") if not -3 <= power < 5 else (1.0, "")
    )
    places = max(0, min(8, 1 - math.floor(math.log10(half * factor))))
    text = f"{value * factor:.{places}f} ± {half * factor:.{places}f}"
    return (f"({text}){mark}" if mark else text) + tail


def parameter_with_interval(name: str, cell: Mapping[str, Any], unit: str = "") -> str:
    """Value ± half of the 95 % interval of a parameter, `tail_fin_lift.arm`; of one that cannot be
    negative and is estimated as 0, the upper end of its interval, which begins at 0.
    """
    value, std = cell.get("value"), cell.get("std")
    if value == 0.0 and std and name in _nonnegative_parameters():
        return f"0, at most {format_number(2.0 * Z_95 * float(std), 2)}{f' {unit}' if unit else ''}"
    return value_with_interval(value, std, unit)


def coefficient_with_interval(cell: Mapping[str, Any]) -> str:
    """A cell of coefficients.json: value ± half of its 95 % interval.

    At a bound, the value and the other end of the interval; without an interval, the value.
    """
    low, high = cell.get("interval_95") or (None, None)
    if side := cell.get("at_bound"):
        end = high if side == "lower" else low
        reach = "" if end is None else f", 95 % limit {format_number(end)}"
        return f"{format_number(cell.get('value'))} (at its bound{reach})"
    if low is None or high is None:
        return value_with_interval(cell.get("value"), cell.get("std"))
    return value_with_interval(cell.get("value"), 0.5 * (high - low) / Z_95)


def format_unit(name: str) -> str:
    """Unit as printed."""
    return UNIT_SYMBOLS.get(name, name)


def format_percent(value: Any, places: int = 1) -> str:
    """Signed percentage with `places` decimals."""
    unknown = value is None or not math.isfinite(float(value))
    return "–" if unknown else f"{float(value):+.{places}f} %"


def format_probability(value: Any) -> str:
    """A share or probability as a percentage; a dash for None."""
    return "–" if value is None else f"{100 * float(value):.0f} %"


def readable_name(name: str) -> str:
    """A cause's name with spaces."""
    return name.replace("_", " ")


def with_readable_names(sentence: str, names: Iterable[str]) -> str:
    """A sentence with the causes' names written with spaces."""
    known = sorted((re.escape(name) for name in names if "_" in name), key=len, reverse=True)
    if not known:
        return sentence
    return re.sub(rf"\b({'|'.join(known)})\b", lambda found: readable_name(found[1]), sentence)


@lru_cache(maxsize=1)
def parameter_units() -> dict[str, str]:
    """Printed unit of every coefficient (`C_T`) and of every effect's parameter (`stall.k`)."""
    return {p.name: format_unit(p.unit) for p in two_plate_system().parameters}


@lru_cache(maxsize=1)
def _nonnegative_parameters() -> frozenset[str]:
    """Parameters whose smallest value is 0."""
    return frozenset(p.name for p in two_plate_system().parameters if p.lower == 0.0)


def _superscript(power: int) -> str:
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
