"""Model predictions for figures: coefficients of each power, extrapolated to untested powers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ...campaign import Campaign
from ...data import Float
from ...design_space import OperatingCondition, steady_states
from ...integrate import LANES, compile_system
from ...integrate.batch import repeat_over_lanes, simulate_batch
from ...model import Simulation, constants_of_robot_trial, simulate, two_plate_system

BAND_DRAWS, MIN_BAND_DRAWS = LANES - 1, 5
"""Draws of the coefficients from which a band is made, and the fewest that must be finite."""
EXTRAPOLATED_POWERS_PCT = (50.0, 75.0, 100.0, 125.0, 150.0)
"""Powers to which the paper extends its simulations, %."""
EXTRAPOLATED_COEFFICIENTS = ("C_Md", "C_Da")
"""Coefficients that the paper extrapolates linearly over power, as f; the others stay constant."""


@dataclass(frozen=True)
class FitAtPower:
    """Coefficients (SI) and flapping frequency at one power, tuned or extrapolated.

    draws: name -> (draws,), samples of the fit's distribution, aligned over names and powers; may
    be empty.
    """

    power_pct: float
    flap_hz: float
    coefficients: Mapping[str, float]
    tested: bool
    draws: Mapping[str, Float] = field(default_factory=dict)


@dataclass(frozen=True)
class PredictionWithBand:
    """Predictions along a sweep, (n,), with a 95 % band; the band is NaN without draws."""

    best: Float
    low: Float
    high: Float


def fits_at_tested_powers(campaign: Campaign) -> dict[float, FitAtPower]:
    """Results of the paper's steps at each tested power; empty before the tuning."""
    steps = campaign.coefficients.get("paper_steps", {})
    rows = [_fit_from_json_entry(float(power), entry) for power, entry in steps.items()]
    return {row.power_pct: row for row in sorted((r for r in rows if r), key=_motor_power_sort_key)}


def fits_at_tested_and_extrapolated_powers(campaign: Campaign) -> dict[float, FitAtPower]:
    """Tested powers, and 50 to 150 % with f, C_Md and C_Da extrapolated linearly over power.

    Least-squares lines through all tested powers; a single tested power is not extrapolated.
    """
    known = fits_at_tested_powers(campaign)
    if len(known) < 2:
        return known
    added = [p for p in EXTRAPOLATED_POWERS_PCT if p not in known]
    rows = [*known.values(), *(_extrapolated_fit(known, p) for p in added)]
    return {row.power_pct: row for row in sorted(rows, key=_motor_power_sort_key)}


def simulate_from_rest(
    campaign: Campaign, row: FitAtPower, head_length_m: float, duration_s: float
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


def speed_from_rest(campaign: Campaign, row: FitAtPower, times: Float) -> PredictionWithBand:
    """Speed of a straight run from rest of the 1x head at times (n,), m/s."""
    head = campaign.study.setup.robot.head_length_m
    lanes = _best_and_drawn_parameter_vectors(row)[:LANES]
    short = LANES - len(lanes)
    values = np.vstack([lanes, np.repeat(lanes[:1], short, axis=0)]).T[None]
    fixed = repeat_over_lanes(constants_of_robot_trial(campaign.study.setup, head)[None])
    system = two_plate_system()
    _, states = simulate_batch(
        compile_system(system), np.zeros((1, len(system.all_states), LANES)), values, fixed,
        times=times[None], inputs=np.tile([0.0, row.flap_hz], (1, len(times), 1)),
        keep_states=True,
    )  # fmt: skip
    return _best_with_95_pct_band(np.hypot(states[0, :, 3], states[0, :, 4])[:, : len(lanes)])


def turn_radii(
    campaign: Campaign,
    row: FitAtPower,
    head_lengths_m: Iterable[float],
    angles_deg: Iterable[float],
) -> PredictionWithBand:
    """Steady turn radii (m) at pairs of head length and angle; NaN without a steady turn."""
    conditions = [
        OperatingCondition(row.flap_hz, math.radians(angle), length, campaign.study.setup)
        for length, angle in zip(head_lengths_m, angles_deg, strict=True)
    ]
    found = steady_states(conditions, _best_and_drawn_parameter_vectors(row)).radius_m
    return _best_with_95_pct_band(np.where(np.isfinite(found), found, np.nan))


def turn_radius(
    campaign: Campaign, row: FitAtPower, head_length_m: float, angle_deg: float
) -> float:
    """Steady turn radius, m; NaN without a steady turn."""
    return float(turn_radii(campaign, row, [head_length_m], [angle_deg]).best[0])


def turn_radii_over_head_angle(
    campaign: Campaign, row: FitAtPower, head_length_m: float, angles_deg: Iterable[float]
) -> PredictionWithBand:
    """Radii at head angles, m."""
    angles = list(angles_deg)
    return turn_radii(campaign, row, [head_length_m] * len(angles), angles)


def turn_radii_over_head_length(
    campaign: Campaign, row: FitAtPower, lengths_m: Iterable[float], angle_deg: float
) -> PredictionWithBand:
    """Radii at head lengths, m."""
    lengths = list(lengths_m)
    return turn_radii(campaign, row, lengths, [angle_deg] * len(lengths))


def _best_and_drawn_parameter_vectors(row: FitAtPower) -> Float:
    """Parameter vectors (1 + draws, parameters), the best estimate first."""
    count = len(next(iter(row.draws.values()), ()))
    drawn = [{name: float(v[k]) for name, v in row.draws.items()} for k in range(count)]
    return np.array(
        [two_plate_system().parameter_vector(one) for one in (dict(row.coefficients), *drawn)]
    )


def _best_with_95_pct_band(values: Float) -> PredictionWithBand:
    """Best estimate (first column), band of 1.96 standard deviations of the draws' logarithms."""
    best, rest = values[:, 0], values[:, 1:]
    with np.errstate(invalid="ignore", divide="ignore"):
        logs = np.where(rest > 0, np.log(rest), np.nan)
        known = np.isfinite(logs).sum(axis=1) >= MIN_BAND_DRAWS
    spread = np.full(len(best), np.nan)
    if known.any():
        spread[known] = 1.96 * np.nanstd(logs[known], axis=1, ddof=1)
    return PredictionWithBand(best, best * np.exp(-spread), best * np.exp(spread))


def _motor_power_sort_key(row: FitAtPower) -> float:
    return row.power_pct


def _fit_from_json_entry(power: float, entry: Mapping[str, object]) -> FitAtPower | None:
    cells = entry.get("coefficients")
    flap_hz = entry.get("flap_hz")
    if not isinstance(cells, Mapping) or not isinstance(flap_hz, (int, float)):
        return None
    values = {name: cell.get("value") for name, cell in cells.items()}
    if any(value is None for value in values.values()):
        return None
    best = {k: float(v) for k, v in values.items()}
    return FitAtPower(
        power, float(flap_hz), best, True, _coefficient_draws(entry.get("ensemble"), best)
    )


def _coefficient_draws(ensemble: object, best: Mapping[str, float]) -> dict[str, Float]:
    """Draws by name, at most `BAND_DRAWS`; constant for coefficients that were not fitted."""
    if not isinstance(ensemble, Mapping):
        return {}
    rows = np.array(ensemble["values"], dtype=np.float64)[:BAND_DRAWS]
    given = dict(zip(ensemble["names"], rows.T, strict=True))
    return {name: given.get(name, np.full(len(rows), value)) for name, value in best.items()}


def _extrapolated_fit(known: Mapping[float, FitAtPower], power: float) -> FitAtPower:
    """Coefficients of an untested power; the constant ones come from the nearest tested power."""
    rows = list(known.values())
    nearest = min(rows, key=lambda row: abs(row.power_pct - power))
    at = np.array([row.power_pct for row in rows])

    def line(values: list[float]) -> float:
        return float(np.polyval(np.polyfit(at, values, 1), power))

    drawn = {
        name: line([row.coefficients[name] for row in rows]) for name in EXTRAPOLATED_COEFFICIENTS
    }
    flap_hz = line([row.flap_hz for row in rows])
    draws = dict(nearest.draws)
    if all(row.draws for row in rows):
        for name in EXTRAPOLATED_COEFFICIENTS:
            every = np.array([row.draws[name] for row in rows])
            draws[name] = np.array([line(list(column)) for column in every.T])
    return FitAtPower(power, flap_hz, {**nearest.coefficients, **drawn}, False, draws)
