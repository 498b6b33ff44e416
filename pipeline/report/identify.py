"""What the data determine: the Fisher spectrum in words, and a profile likelihood a coefficient."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..campaign import Campaign
from ..data import Float
from .numbers import number, unit
from .story import Row

LOST_AT_95 = 1.92
"""Log likelihood lost at the ends of a 95 % interval: half of chi squared of one degree."""
WIDTH, HEIGHT, TOP = 100.0, 60.0, 6.0
DRAWN = 41
"""Points of a drawn profile."""


@dataclass(frozen=True)
class Profile:
    """A profile as drawn, 100 by 60: points of the curve, place of the fitted value, and words."""

    name: str
    points: str
    value_x: float
    interval: str
    ends: tuple[str, str]
    limit_y: float = HEIGHT * (1.0 - LOST_AT_95 / TOP)


def spectrum(campaign: Campaign) -> list[Row]:
    """Combinations of coefficients, the least determined first, with their deviation."""
    return [
        Row(
            str(one.get("combination", "")),
            (_percent(one.get("relative_std")), "yes" if one.get("determined") else "no"),
            not one.get("determined", True),
        )
        for one in _identifiability(campaign).get("spectrum") or []
    ]


def profiles(campaign: Campaign) -> list[Profile]:
    """A drawn profile for each coefficient that has one."""
    cells = (campaign.coefficients.get("joint") or {}).get("coefficients") or {}
    found = _identifiability(campaign).get("profiles") or {}
    drawn = [_profile(name, one, cells.get(name) or {}) for name, one in found.items()]
    return [one for one in drawn if one is not None]


def _profile(name: str, one: Mapping[str, Any], cell: Mapping[str, Any]) -> Profile | None:
    best = cell.get("value")
    if best is None or not one.get("values"):
        return None
    at = np.array([*one["values"], best], dtype=float)
    lost = np.array([*one["lost"], 0.0], dtype=float)
    known = np.isfinite(at) & np.isfinite(lost)
    order = np.argsort(at[known])
    at, lost = _between(at[known][order], lost[known][order], float(best))
    span = float(np.ptp(at)) or 1.0
    x, y = WIDTH * (at - at[0]) / span, HEIGHT * (1.0 - np.clip(lost, 0.0, TOP) / TOP)
    low, high = (_missing(cell, side) for side in ("lower", "upper"))
    words = f"{_end(one.get('lower'), low)} to {_end(one.get('upper'), high)}"
    return Profile(
        name,
        " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True)),
        WIDTH * (float(best) - float(at[0])) / span,
        f"{words} {unit(str(cell.get('unit', '')))}".replace(" –", ""),
        (number(at[0]), number(at[-1])),
    )


def _between(at: Float, lost: Float, best: float) -> tuple[Float, Float]:
    """Points (n,) of a smooth profile through those known: the root of what is lost goes along
    straight lines, as it does for a parabola.
    """
    root = np.sqrt(np.maximum(lost, 0.0)) * np.sign(at - best)
    every = np.union1d(at, np.linspace(at[0], at[-1], DRAWN))
    return every, np.interp(every, at, root) ** 2


def _identifiability(campaign: Campaign) -> Mapping[str, Any]:
    return (campaign.coefficients.get("joint") or {}).get("identifiability") or {}


def _missing(cell: Mapping[str, Any], side: str) -> str:
    """What to say where the likelihood has no end on one side: the number may be at its bound."""
    return "its bound" if cell.get("at_bound") == side else f"no {side} end"


def _end(value: Any, missing: str) -> str:
    return missing if value is None or not np.isfinite(value) else number(value)


def _percent(value: Any) -> str:
    return "nothing known" if value is None else f"{100 * float(value):.2g} %"
