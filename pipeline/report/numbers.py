"""Numbers as a person reads them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Any

from ..model import plates

BAND = 1.96
UNITS = {"m2": "m²", "kg m2": "kg m²", "kg_m2": "kg m²", "1": "–", "": "–"}


def number(value: Any, digits: int = 3) -> str:
    """A number with so many significant digits; a dash where there is none."""
    if value is None or not math.isfinite(float(value)):
        return "–"
    value = float(value)
    if value != 0 and not 1e-3 <= abs(value) < 1e5:
        mantissa, power = f"{value:.{digits - 1}e}".split("e")
        return f"{mantissa} × 10{_raised(int(power))}"
    places = max(0, digits - 1 - math.floor(math.log10(abs(value)))) if value else 0
    return f"{value:.{places}f}"


def measured(value: Any, std: Any, unit: str = "") -> str:
    """Value ± 95 % half-width, the value to the place of its uncertainty."""
    tail = f" {unit}" if unit and unit != "–" else ""
    if value is None or not math.isfinite(float(value)):
        return "–"
    if std is None or not math.isfinite(float(std)) or float(std) <= 0:
        return number(value) + tail
    value, half = float(value), BAND * float(std)
    power = math.floor(math.log10(max(abs(value), half))) if value else 0
    factor, mark = (10.0**-power, f" × 10{_raised(power)}") if not -3 <= power < 5 else (1.0, "")
    places = max(0, min(8, 1 - math.floor(math.log10(half * factor))))
    text = f"{value * factor:.{places}f} ± {half * factor:.{places}f}"
    return (f"({text}){mark}" if mark else text) + tail


def estimate(cell: Mapping[str, Any]) -> str:
    """A coefficient as in coefficients.json: value ± half its 95 % interval, at a bound how far
    from it the interval reaches, else the value alone.
    """
    low, high = cell.get("interval_95") or (None, None)
    if side := cell.get("at_bound"):
        end = high if side == "lower" else low
        reach = "" if end is None else f", {'up' if side == 'lower' else 'down'} to {number(end)}"
        return f"{number(cell.get('value'))} (at its bound{reach})"
    if low is None or high is None:
        return measured(cell.get("value"), cell.get("std"))
    return measured(cell.get("value"), 0.5 * (high - low) / BAND)


def unit(name: str) -> str:
    """Unit as printed."""
    return UNITS.get(name, name)


def percent(value: Any, places: int = 1) -> str:
    """Signed percent with so many decimals."""
    unknown = value is None or not math.isfinite(float(value))
    return "–" if unknown else f"{float(value):+.{places}f} %"


def words(name: str) -> str:
    """A cause's name in words."""
    return name.replace("_", " ")


def in_words(sentence: str, names: Iterable[str]) -> str:
    """A sentence with the causes' names in words."""
    known = sorted((re.escape(name) for name in names if "_" in name), key=len, reverse=True)
    if not known:
        return sentence
    return re.sub(rf"\b({'|'.join(known)})\b", lambda found: words(found[1]), sentence)


@lru_cache(maxsize=1)
def units() -> dict[str, str]:
    """Printed unit of every coefficient (`C_T`) and of every effect's parameter (`stall.k`)."""
    return {p.name: unit(p.unit) for p in plates().parameters}


def _raised(power: int) -> str:
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
