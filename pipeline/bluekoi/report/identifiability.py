"""Identifiability: Fisher spectrum as a table, and the profile likelihood of each coefficient."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..campaign import Campaign
from ..data import Float
from .findings import TableRow
from .numbers import format_number, format_unit

LOG_LIK_DROP_95 = 1.92
"""Drop in log likelihood at the ends of a 95 % interval: half of chi-squared(1) at 0.95."""
CURVE_WIDTH, CURVE_HEIGHT, MAX_DROP_SHOWN = 100.0, 60.0, 6.0
"""Size of a curve's drawing, and the largest drop in log likelihood that it shows."""
CURVE_POINTS = 41
COMBINATION_TERM_PATTERN = re.compile(r"([+-]\d*\.?\d+) d(\w+)/")


@dataclass(frozen=True)
class ProfileCurve:
    """A profile drawn in a box of 100 by 60: curve, position of the estimate, interval as text."""

    name: str
    points: str
    value_x: float
    interval: str
    ends: tuple[str, str]
    limit_y: float = CURVE_HEIGHT * (1.0 - LOG_LIK_DROP_95 / MAX_DROP_SHOWN)


def fisher_spectrum(campaign: Campaign) -> list[TableRow]:
    """Combinations of coefficients, the least determined first, with relative standard errors."""
    return [
        TableRow(
            as_power_product(str(one.get("combination", ""))),
            (_percent_text(one.get("relative_std")), "yes" if one.get("determined") else "no"),
            not one.get("determined", True),
        )
        for one in _joint_fit_identifiability(campaign).get("spectrum") or []
    ]


def as_power_product(text: str) -> str:
    """A combination of relative changes as a product of powers.

    sum w_i dC_i/C_i = d ln prod C_i^w_i, so `+0.58 dC_T/C_T -0.37 dC_Da/C_Da` reads
    `C_T^0.58 · C_Da^−0.37`, and a single coefficient stands alone. Unknown formats unchanged.
    """
    terms = COMBINATION_TERM_PATTERN.findall(text)
    if len(terms) == 1:
        return str(terms[0][1])
    sign = -1.0 if terms and float(terms[0][0]) < 0 else 1.0
    powers = [f"{name}^{sign * float(weight):.2f}".replace("-", "−") for weight, name in terms]
    return " · ".join(powers) or text


def likelihood_profile_curves(campaign: Campaign) -> list[ProfileCurve]:
    """The profile of each coefficient that has one."""
    cells = (campaign.coefficients.get("joint") or {}).get("coefficients") or {}
    found = _joint_fit_identifiability(campaign).get("profiles") or {}
    drawn = [_profile_curve(name, one, cells.get(name) or {}) for name, one in found.items()]
    return [one for one in drawn if one is not None]


def _profile_curve(
    name: str, one: Mapping[str, Any], cell: Mapping[str, Any]
) -> ProfileCurve | None:
    best = cell.get("value")
    if best is None or not one.get("values"):
        return None
    at = np.array([*one["values"], best], dtype=float)
    lost = np.array([*one["lost"], 0.0], dtype=float)
    known = np.isfinite(at) & np.isfinite(lost)
    order = np.argsort(at[known])
    at, lost = _interpolated_profile(at[known][order], lost[known][order], float(best))
    span = float(np.ptp(at)) or 1.0
    x, y = (
        CURVE_WIDTH * (at - at[0]) / span,
        CURVE_HEIGHT * (1.0 - np.clip(lost, 0.0, MAX_DROP_SHOWN) / MAX_DROP_SHOWN),
    )
    low, high = (_open_interval_end_text(cell, side) for side in ("lower", "upper"))
    start, end = one.get("lower"), one.get("upper")
    words = f"{_interval_end_text(start, low)} to {_interval_end_text(end, high)}"
    return ProfileCurve(
        name,
        " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True)),
        CURVE_WIDTH * (float(best) - float(at[0])) / span,
        f"{words} {format_unit(str(cell.get('unit', '')))}".replace(" –", ""),
        (format_number(at[0]), format_number(at[-1])),
    )


def _interpolated_profile(at: Float, lost: Float, best: float) -> tuple[Float, Float]:
    """A smooth profile: interpolated in its signed square root, which is linear for a parabola."""
    root = np.sqrt(np.maximum(lost, 0.0)) * np.sign(at - best)
    every = np.union1d(at, np.linspace(at[0], at[-1], CURVE_POINTS))
    return every, np.interp(every, at, root) ** 2


def _joint_fit_identifiability(campaign: Campaign) -> Mapping[str, Any]:
    return (campaign.coefficients.get("joint") or {}).get("identifiability") or {}


def _open_interval_end_text(cell: Mapping[str, Any], side: str) -> str:
    """Text for an open side of the interval."""
    return "bound" if cell.get("at_bound") == side else f"no {side} end"


def _interval_end_text(value: Any, missing: str) -> str:
    return missing if value is None or not np.isfinite(value) else format_number(value)


def _percent_text(value: Any) -> str:
    return "unbounded" if value is None else f"{100 * float(value):.2g} %"
