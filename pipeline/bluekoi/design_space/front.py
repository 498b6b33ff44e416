"""Which designs are worth building: none other is both faster and tighter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..data import Float

MIN_RELATIVE_RADIUS_REDUCTION = 0.001
"""Share by which the radius of a slower design must be smaller to be on the front."""
DESIGN_COLUMNS = (
    "power_pct", "flap_hz", "head_angle_deg", "head_length_m", "speed_m_s", "speed_low_m_s",
    "speed_high_m_s", "radius_m", "radius_low_m", "radius_high_m", "on_front", "extrapolated",
)  # fmt: skip
"""Columns of designs.csv."""


@dataclass(frozen=True)
class RobotDesign:
    """One design: what is set, and steady speed and radius as (best, lower, upper 95 % bound).

    extrapolated: names of the settings outside the tested range.
    """

    power_pct: float
    flap_hz: float
    head_angle_deg: float
    head_length_m: float
    speed_m_s: tuple[float, float, float]
    radius_m: tuple[float, float, float]
    extrapolated: tuple[str, ...] = ()
    other: Mapping[str, float] = field(default_factory=dict)


def is_pareto_optimal(designs: Sequence[RobotDesign]) -> Float:
    """Which designs no other beats in both speed and radius, bool (designs,).

    Where the radius does not depend on power, ties in it would make a wall of slower designs:
    slower ones must be tighter by `MIN_RELATIVE_RADIUS_REDUCTION`.
    """
    pairs = np.array([[-d.speed_m_s[0], d.radius_m[0]] for d in designs])
    valid = np.isfinite(pairs).all(axis=1)
    out = np.zeros(len(designs), dtype=bool)
    tightest = np.inf
    for i in np.lexsort((pairs[:, 1], pairs[:, 0])):
        if valid[i] and pairs[i, 1] < (1 - MIN_RELATIVE_RADIUS_REDUCTION) * tightest:
            out[i], tightest = True, pairs[i, 1]
    return out


def tightest_turn_design(
    designs: Sequence[RobotDesign], *, min_speed_m_s: float = 0.0, tested_only: bool = False
) -> RobotDesign | None:
    """The tightest turn among designs at least so fast; None where there is none.

    Of those within `MIN_RELATIVE_RADIUS_REDUCTION` of the tightest, tested ones come first, then
    the fastest.
    """
    fit = [
        d
        for d in designs
        if np.isfinite(d.radius_m[0])
        and d.speed_m_s[0] >= min_speed_m_s
        and not (tested_only and d.extrapolated)
    ]
    tightest = min((d.radius_m[0] for d in fit), default=np.inf)
    ties = [d for d in fit if d.radius_m[0] <= tightest * (1 + MIN_RELATIVE_RADIUS_REDUCTION)]
    return min(ties, key=lambda d: (len(d.extrapolated), -d.speed_m_s[0]), default=None)


def designs_csv_columns(designs: Sequence[RobotDesign]) -> dict[str, list[Any]]:
    """Columns of designs.csv; further dimensions of the robot come last."""
    front = is_pareto_optimal(designs)
    rows = [
        (d.power_pct, d.flap_hz, d.head_angle_deg, d.head_length_m, *d.speed_m_s, *d.radius_m,
         bool(front[i]), " and ".join(d.extrapolated))
        for i, d in enumerate(designs)
    ]  # fmt: skip
    out = {name: [row[k] for row in rows] for k, name in enumerate(DESIGN_COLUMNS)}
    for key in designs[0].other if designs else ():
        out[key] = [d.other[key] for d in designs]
    return out
