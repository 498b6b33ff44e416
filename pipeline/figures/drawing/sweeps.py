"""The model's answers for figures: coefficients of each power, extended beyond the tested ones."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from ...campaign import Campaign
from ...data import Float
from ...model import Simulation, simulate, steady_turn

EXTENDED_PCT = (50.0, 75.0, 100.0, 125.0, 150.0)
EXTRAPOLATED = ("C_Md", "C_Da")
"""What the paper extends along a line over power, beside f; the rest is held."""


@dataclass(frozen=True)
class Tuned:
    """Coefficients (SI) and flapping frequency at one power; tested or extended along a line."""

    power_pct: float
    flap_hz: float
    coefficients: Mapping[str, float]
    tested: bool


def tuned(campaign: Campaign) -> dict[float, Tuned]:
    """The paper's steps at each power tested, from coefficients.json; empty before the tuning."""
    steps = campaign.coefficients.get("paper_steps", {})
    rows = [_tuned(float(power), entry) for power, entry in steps.items()]
    return {row.power_pct: row for row in sorted((r for r in rows if r), key=_power)}


def extended(campaign: Campaign) -> dict[float, Tuned]:
    """Tested powers, and 50 to 150 % along straight lines in f, C_Md and C_Da over power.

    The lines are least squares through all tested powers; one tested power is not extended.
    """
    known = tuned(campaign)
    if len(known) < 2:
        return known
    added = [p for p in EXTENDED_PCT if p not in known]
    rows = [*known.values(), *(_on_the_line(known, p) for p in added)]
    return {row.power_pct: row for row in sorted(rows, key=_power)}


def from_rest(
    campaign: Campaign, row: Tuned, head_length_m: float, duration_s: float
) -> Simulation:
    """Straight run from rest at one power."""
    return simulate(
        row.coefficients,
        setup=campaign.study.setup,
        head_length_m=head_length_m,
        head_angle_rad=0.0,
        flap_hz=row.flap_hz,
        duration_s=duration_s,
    )


def radius(campaign: Campaign, row: Tuned, head_length_m: float, angle_deg: float) -> float:
    """Steady turn radius, m; NaN where the model does not settle into a turn."""
    _, found = steady_turn(
        row.coefficients,
        setup=campaign.study.setup,
        head_length_m=head_length_m,
        head_angle_rad=math.radians(angle_deg),
        flap_hz=row.flap_hz,
    )
    return found if math.isfinite(found) else math.nan


def over_angle(
    campaign: Campaign, row: Tuned, head_length_m: float, angles_deg: Iterable[float]
) -> Float:
    """Radii at head angles, (n,), m."""
    return np.array([radius(campaign, row, head_length_m, angle) for angle in angles_deg])


def over_length(
    campaign: Campaign, row: Tuned, lengths_m: Iterable[float], angle_deg: float
) -> Float:
    """Radii at head lengths, (n,), m."""
    return np.array([radius(campaign, row, length, angle_deg) for length in lengths_m])


def _power(row: Tuned) -> float:
    return row.power_pct


def _tuned(power: float, entry: Mapping[str, object]) -> Tuned | None:
    cells = entry.get("coefficients")
    flap_hz = entry.get("flap_hz")
    if not isinstance(cells, Mapping) or not isinstance(flap_hz, (int, float)):
        return None
    values = {name: cell.get("value") for name, cell in cells.items()}
    if any(value is None for value in values.values()):
        return None
    return Tuned(power, float(flap_hz), {k: float(v) for k, v in values.items()}, True)


def _on_the_line(known: Mapping[float, Tuned], power: float) -> Tuned:
    """Coefficients of an untested power; those held come from the nearest tested power."""
    rows = list(known.values())
    nearest = min(rows, key=lambda row: abs(row.power_pct - power))
    at = np.array([row.power_pct for row in rows])

    def line(values: list[float]) -> float:
        return float(np.polyval(np.polyfit(at, values, 1), power))

    drawn = {name: line([row.coefficients[name] for row in rows]) for name in EXTRAPOLATED}
    flap_hz = line([row.flap_hz for row in rows])
    return Tuned(power, flap_hz, {**nearest.coefficients, **drawn}, False)
