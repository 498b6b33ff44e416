"""The paper's three steps at each power, as published (section V-A).

Step 1: straight runs of the 1x head give C_T and C_D0, one pair for all powers, from equilibrium
speeds and, since the mass is known, from the start. The paper assigns C_Da to this step too; a
straight run holds alpha at 0 and says nothing about it, so it is fitted in step 2.
Step 2: turns of the 1x head give C_La and C_Ma for all powers, C_Da and C_Md at each power.
Step 3: turns of the longer head are predicted, not fitted.
The values are as published: step 2 takes those of step 1 as they are. Their errors are not: step
1's covariance enters that of step 2 (`with_earlier_step_covariance`), and since a step has few
trials, which may agree by chance, no variance is stated that is less than the naive one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..data import Float, SteadyState
from ..fitting import FreeParameter, TrialSeries
from ..model import robot_system, steady_speed_and_radius
from ..study import Robot, Study, Trial
from .draws import clip_to_bounds, sample_parameters
from .joint_fit import JointFit, coefficient_cell, fit_all_trials
from .similar_robots import compiled_trial_system
from .two_step_covariance import sensitivity_to_earlier_step, with_earlier_step_covariance

MAX_STRAIGHT_ANGLE_DEG = 3.0
"""Head angle below which a trial is a straight run."""
STEP_DRAWS, DRAW_SEED = 60, 0
"""Draws of the coefficients of a step, and their seed."""
MIN_VARIANCE_OVER_NAIVE = 1.0
"""No variance of a step is less than this share of the naive one."""
COMMON_COEFFICIENTS = ("C_T", "C_D0", "C_La", "C_Ma")
"""Coefficients that the paper holds equal at all powers."""
COEFFICIENTS_PER_POWER = ("C_Da", "C_Md")
"""Coefficients that the paper fits at each power."""


def fit_paper_steps(
    study: Study, series: Sequence[TrialSeries], steady: Mapping[str, SteadyState]
) -> tuple[dict[str, Any], JointFit | None, JointFit | None]:
    """Result by power as in coefficients.json, and the fits of steps 1 and 2.

    A step whose trials are missing is None and its coefficients are said to be undetermined.
    """
    trials = {t.trial_id: t for t in study.trials}
    one_x = [s for s in series if _has_one_x_head(study, trials[s.name])]
    straight = [s for s in one_x if has_straight_head(trials[s.name])]
    turns = [s for s in one_x if not has_straight_head(trials[s.name])]
    first = (
        fit_all_trials(
            straight,
            [FreeParameter("C_T"), FreeParameter("C_D0")],
            min_share=MIN_VARIANCE_OVER_NAIVE,
        )
        if straight
        else None
    )
    own = _fit_second_step(turns, first) if turns else None
    sensitivity = sensitivity_to_earlier_step(turns, own, first) if own and first else None
    second = (
        own
        if own is None or first is None or sensitivity is None
        else with_earlier_step_covariance(own, first, sensitivity)
    )
    powers = sorted({s.group for s in series}, key=float)
    sampled = sample_step_parameters((first, own), sensitivity, np.random.default_rng(DRAW_SEED))
    result = {
        p: _results_of_power(study, p, series, steady, (first, second))
        | {"ensemble": _coefficient_draws_of_power(sampled, p)}
        for p in powers
    }
    return result, first, second


def sample_step_parameters(
    fits: tuple[JointFit | None, JointFit | None],
    sensitivity: Float | None,
    rng: np.random.Generator,
) -> dict[str, list[float]]:
    """`STEP_DRAWS` values of every number that was fitted, by label, step by step.

    fits: as fitted. sensitivity: how step 2's numbers go with those of step 1, draw by draw.
    """
    out: dict[str, list[float]] = {}
    rows = [sample_parameters(one, STEP_DRAWS, rng) if one else None for one in fits]
    if (
        fits[0]
        and fits[1]
        and rows[0] is not None
        and rows[1] is not None
        and sensitivity is not None
    ):
        rows[1] = clip_to_bounds(
            fits[1].fit, rows[1] + (rows[0] - fits[0].fit.values) @ sensitivity.T
        )
    for one, values in zip(fits, rows, strict=True):
        if one and values is not None:
            out |= dict(zip([f.label for f in one.fit.free], values.T.tolist(), strict=True))
    return out


def _coefficient_draws_of_power(sampled: Mapping[str, list[float]], power: str) -> dict[str, Any]:
    """Draws for one power: the common numbers and those of this power, (draws, numbers)."""
    own = {name.split("@")[0]: v for name, v in sampled.items() if name.endswith(f"@{power}")}
    common = {name: v for name, v in sampled.items() if "@" not in name}
    both = common | own
    return {"names": list(both), "values": np.array(list(both.values())).T}


def has_straight_head(trial: Trial) -> bool:
    """Whether the head was straight."""
    return abs(trial.head_angle_deg) < MAX_STRAIGHT_ANGLE_DEG


def _has_one_x_head(study: Study, trial: Trial) -> bool:
    return abs(trial.head_length_m - study.setup.robot.head_length_m) < 1e-6


def _fit_second_step(turns: Sequence[TrialSeries], first: JointFit | None) -> JointFit:
    groups = sorted({s.group for s in turns}, key=float)
    free = [
        FreeParameter("C_La"),
        FreeParameter("C_Ma"),
        *(FreeParameter(c, g) for g in groups for c in COEFFICIENTS_PER_POWER),
    ]
    base = compiled_trial_system(turns).system.parameter_vector(
        first.fit.values_by_label() if first else {}
    )
    if first is None:
        free = [FreeParameter("C_T"), FreeParameter("C_D0"), *free]
    return fit_all_trials(turns, free, base=base, min_share=MIN_VARIANCE_OVER_NAIVE)


def _results_of_power(
    study: Study,
    power: str,
    series: Sequence[TrialSeries],
    steady: Mapping[str, SteadyState],
    fits: tuple[JointFit | None, JointFit | None],
) -> dict[str, Any]:
    here = [s for s in series if s.group == power]
    flap_hz = float(np.mean([s.inputs[0, 1] for s in here]))
    coefficients = {
        name: _coefficient_entry(study.setup.robot, name, power, fits)
        for name in (*COMMON_COEFFICIENTS, *COEFFICIENTS_PER_POWER)
    }
    values = {name: c["value"] for name, c in coefficients.items()}
    return {
        "flap_hz": flap_hz,
        "coefficients": coefficients,
        "steps": _compare_measured_with_simulated(study, here, steady, values, flap_hz),
    }


def _coefficient_entry(
    robot: Robot, name: str, power: str, fits: tuple[JointFit | None, JointFit | None]
) -> dict[str, Any]:
    parameter = next(p for p in robot_system(robot).parameters if p.name == name)
    for step, fitted in enumerate(fits, start=1):
        labels = [f.label for f in fitted.fit.free] if fitted else []
        label = next((k for k in (name, f"{name}@{power}") if k in labels), None)
        if fitted and label:
            return coefficient_cell(fitted, labels.index(label)) | {"step": step}
    why = "no straight runs of the 1x head" if name in ("C_T", "C_D0") else (
        "no turns of the 1x head at this power: straight runs hold alpha at 0 and say nothing of it"
    )  # fmt: skip
    return {"value": parameter.start, "std": None, "interval_95": [None, None], "naive_std": None,
            "unit": parameter.unit, "step": None, "determined": False, "why": why}  # fmt: skip


def _compare_measured_with_simulated(
    study: Study,
    series: Sequence[TrialSeries],
    steady: Mapping[str, SteadyState],
    coefficients: Mapping[str, float],
    flap_hz: float,
) -> dict[str, Any]:
    """Measured and simulated speed and radius by condition of one power, both sides in one."""
    trials = {t.trial_id: t for t in study.trials}
    groups: dict[tuple[float, float], list[str]] = {}
    for s in series:
        key = (abs(trials[s.name].head_angle_deg), trials[s.name].head_length_m)
        groups.setdefault(key, []).append(s.name)
    return {
        f"{angle:g} deg, {length:g} m": {
            "head_angle_deg": angle,
            "head_length_m": length,
            "trials": ids,
            "step": _paper_step_of_condition(study, angle, length),
            **_compare_with_measurement(study, (angle, length),
                                        [steady[i] for i in ids if i in steady],
                                        coefficients, flap_hz),
        }
        for (angle, length), ids in sorted(groups.items())
    }  # fmt: skip


def _paper_step_of_condition(study: Study, angle: float, length: float) -> int:
    if abs(length - study.setup.robot.head_length_m) > 1e-6:
        return 3
    return 1 if angle < MAX_STRAIGHT_ANGLE_DEG else 2


def _compare_with_measurement(
    study: Study,
    condition: tuple[float, float],
    measured: Sequence[SteadyState],
    coefficients: Mapping[str, float],
    flap_hz: float,
) -> dict[str, Any]:
    angle, length = condition
    speed, radius = steady_speed_and_radius(
        coefficients,
        setup=study.setup,
        head_length_m=length,
        head_angle_rad=np.radians(angle if angle >= MAX_STRAIGHT_ANGLE_DEG else 0.0),
        flap_hz=flap_hz,
    )
    speeds = [s.speed_m_s for s in measured if np.isfinite(s.speed_m_s)]
    radii = [
        s.radius_m for s in measured if np.isfinite(s.radius_m) and angle >= MAX_STRAIGHT_ANGLE_DEG
    ]
    seen_radius = float(np.mean(radii)) if radii else None
    return {
        "speed_m_s": float(np.mean(speeds)) if speeds else None,
        "speed_spread_m_s": float(np.std(speeds, ddof=1)) if len(speeds) > 1 else None,
        "radius_m": seen_radius,
        "radius_spread_m": float(np.std(radii, ddof=1)) if len(radii) > 1 else None,
        "model_speed_m_s": speed,
        "model_radius_m": radius if np.isfinite(radius) else None,
        "radius_difference_pct": 100 * (radius - seen_radius) / seen_radius
        if seen_radius
        else None,
    }
