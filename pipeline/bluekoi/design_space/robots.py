"""Designs of a fitted robot, and the range that was tested."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import ValidationError

from ..data import Float
from ..errors import InputError, did_you_mean, input_error
from ..model import robot_scale_ratios
from ..study import Study, StudySettings
from ..study.validation_messages import issues_of_refused_values
from .fits import COEFFICIENT_DRAWS, FittedRobot
from .front import RobotDesign
from .steady_states import OperatingCondition, steady_states

MAX_DESIGNS = 20_000
"""Designs in one call."""


@dataclass(frozen=True)
class TestedRange:
    """What was tested: lowest and highest power, head angle (its size) and head length."""

    power_pct: tuple[float, float]
    head_angle_deg: tuple[float, float]
    head_length_m: tuple[float, float]

    def outside(self, power_pct: float, head_angle_deg: float, head_length_m: float) -> list[str]:
        """Names of the settings outside the tested range."""
        given = (
            ("power", power_pct, self.power_pct),
            ("head angle", abs(head_angle_deg), self.head_angle_deg),
            ("head length", head_length_m, self.head_length_m),
        )
        return [n for n, v, (low, high) in given if not low - 1e-9 <= v <= high + 1e-9]


def tested_range(study: Study) -> TestedRange:
    """Range of a study's trials; head angles of its turns."""
    trials = study.trials
    angles = [abs(t.head_angle_deg) for t in trials if abs(t.head_angle_deg) >= 3]
    return TestedRange(
        _lowest_and_highest([t.power_pct for t in trials]),
        _lowest_and_highest(angles or [0.0]),
        _lowest_and_highest([t.head_length_m for t in trials]),
    )


def _lowest_and_highest(values: Sequence[float]) -> tuple[float, float]:
    return min(values), max(values)


def evaluate_designs(
    fit: FittedRobot,
    setup: StudySettings,
    tested: TestedRange,
    *,
    powers: Sequence[float],
    angles_deg: Sequence[float],
    lengths_m: Sequence[float],
    other: Mapping[str, Sequence[float]] | None = None,
) -> list[RobotDesign]:
    """Every combination with its steady speed and radius and their 95 % bands.

    other: values of further keys of `robot` in study.yaml, such as `mass_kg`; nothing else about
    the robot changes with them.

    Raises: InputError for a key that the robot does not have, a value that no robot can have, or
    more designs than `MAX_DESIGNS`.
    """
    _refuse_too_many((powers, angles_deg, lengths_m, *(other or {}).values()))
    keys = list(other or {})
    known = set(type(setup.robot).model_fields)
    for key in keys:
        if key not in known:
            raise input_error("robot", key, "an unknown key", "a key of robot in study.yaml",
                        did_you_mean(key, known))  # fmt: skip
    grid = list(itertools.product(powers, angles_deg, lengths_m, *(other or {}).values()))
    robots = [
        _setup_with_changes(setup, dict(zip(keys, rest, strict=True))) for _, _, _, *rest in grid
    ]
    fitted = robot_scale_ratios(setup.robot)
    conditions = [
        OperatingCondition(fit.flap_hz_at_power(p), float(np.radians(a)), h, robot, fitted)
        for (p, a, h, *_), robot in zip(grid, robots, strict=True)
    ]
    states = steady_states(conditions, fit.values)
    return [
        RobotDesign(
            power_pct=p,
            flap_hz=c.flap_hz,
            head_angle_deg=a,
            head_length_m=h,
            other=dict(zip(keys, rest, strict=True)),
            speed_m_s=_best_and_95_bounds(states.speed_m_s[i]),
            radius_m=_best_and_95_bounds(states.radius_m[i]),
            extrapolated=tuple(tested.outside(p, a, h)) + tuple(
                k for k, v in zip(keys, rest, strict=True) if v != getattr(setup.robot, k)
            ),
        )
        for i, ((p, a, h, *rest), c) in enumerate(zip(grid, conditions, strict=True))
    ]  # fmt: skip


def _refuse_too_many(axes: Sequence[Sequence[float]]) -> None:
    count = math.prod(len(values) for values in axes)
    if count > MAX_DESIGNS:
        sizes = " x ".join(str(len(values)) for values in axes)
        raise input_error("design", "", f"{count} designs ({sizes})", f"{MAX_DESIGNS} at most",
                    "Take larger steps or shorter ranges.")  # fmt: skip


def _setup_with_changes(setup: StudySettings, changes: Mapping[str, float]) -> StudySettings:
    if not changes:
        return setup
    contents = setup.model_dump()
    contents["robot"] |= dict(changes)
    try:
        return type(setup).model_validate(contents)
    except ValidationError as error:
        raise InputError(issues_of_refused_values("--robot", error, type(setup))) from error


def _best_and_95_bounds(draws: Float) -> tuple[float, float, float]:
    """Best value, and 95 % bounds from the spread of the draws (in logarithms)."""
    best, rest = draws[0], draws[1:]
    rest = rest[np.isfinite(rest) & (rest > 0)]
    if not np.isfinite(best) or best <= 0 or len(rest) < COEFFICIENT_DRAWS // 2:
        return float(best), float("nan"), float("nan")
    spread = 1.96 * float(np.std(np.log(rest), ddof=1))
    return float(best), float(best * np.exp(-spread)), float(best * np.exp(spread))
