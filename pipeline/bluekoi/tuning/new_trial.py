"""The trial that adds most information on what a study leaves undetermined."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import TrialSeries, trial_normal_equations
from ..integrate import CompiledSystem
from ..integrate.batch import repeat_over_lanes, simulate_batch
from ..model import constants_of_robot_trial
from ..observation import camera_error_inputs
from ..study import StudySettings
from .bounds import bound_sides
from .identify import ParameterCombination, parameter_scales
from .joint_fit import UNDETERMINED_ABOVE_RELATIVE_STD, JointFit
from .similar_robots import compiled_trial_system
from .turning_trials import TURN_COEFFICIENTS, no_trial_turns_head

CANDIDATE_ANGLES_DEG = (0.0, 15.0, 30.0, 45.0, 60.0)
"""Head angles of the trials that may be recommended."""
NEW_TRIAL_S, NEW_RATE_HZ = 5.0, 10.0
"""Duration and observation rate assumed for a recommended trial."""


@dataclass(frozen=True)
class RecommendedTrial:
    """A trial that would help: its condition, and what it leaves of the deviation (0 to 1)."""

    power_pct: float
    head_angle_deg: float
    head_length_m: float
    left: float


def c_optimal_trial(
    series: Sequence[TrialSeries],
    tuned: JointFit,
    setup: StudySettings,
    combination: ParameterCombination,
) -> RecommendedTrial | None:
    """The trial within the robot's range that adds most information on a combination; None if
    none can be simulated.

    Each is simulated with the fitted coefficients (`parameters_for_planned_trials`) and observed
    with the errors of the trials there are; its Fisher matrix is added, and what is left of the
    combination's deviation counts.
    """
    kernel = compiled_trial_system(series)
    size = parameter_scales(tuned)
    tuned = replace(
        tuned, fit=replace(tuned.fit, values=parameters_for_planned_trials(series, tuned))
    )
    conditions = _candidate_conditions(series, setup)
    imagined = [_simulate_candidate_trial(kernel, series, tuned, setup, c) for c in conditions]
    added = trial_normal_equations(kernel, imagined, tuned.base, tuned.fit.free, tuned.fit.values,
                                   noise=tuned.noise).hessian  # fmt: skip
    scale = np.outer(size, size)
    now = tuned.fit.normal.hessian.sum(axis=0) * scale
    v = combination.direction
    before = _direction_variance(now, v)
    left = np.array([
        np.sqrt(_direction_variance(now + H * scale, v) / before)
        if np.isfinite(H).all() else np.inf
        for H in added
    ])  # fmt: skip
    best = int(np.nanargmin(np.append(left, np.inf)))
    if best == len(left) or not np.isfinite(left[best]):
        return None
    power, angle, length = conditions[best]
    return RecommendedTrial(float(power), angle, length, float(left[best]))


def parameters_for_planned_trials(series: Sequence[TrialSeries], tuned: JointFit) -> Float:
    """Values (p,) to imagine trials with: the fitted ones, but the plausible one from which fits
    start where a number stands at a bound or its naive deviation exceeds
    `UNDETERMINED_ABOVE_RELATIVE_STD` of its size: at a bound of 40 simulations run away.
    """
    naive = np.sqrt(np.diag(tuned.fit.naive_cov))
    silent = [f.name in TURN_COEFFICIENTS and no_trial_turns_head(series) for f in tuned.fit.free]
    held = [bool(side) for side in bound_sides(tuned.fit)]
    starts = np.array([p.start for p in tuned.fit.definitions])
    wide = naive > UNDETERMINED_ABOVE_RELATIVE_STD * parameter_scales(tuned)
    return np.where(held | np.array(silent) | wide, starts,
                    tuned.fit.values)  # fmt: skip


def _direction_variance(fisher: Float, direction: Float) -> float:
    floor = 1e-12 * np.trace(fisher) * np.eye(len(fisher))
    return float(direction @ np.linalg.solve(fisher + floor, direction))


def _candidate_conditions(
    series: Sequence[TrialSeries], setup: StudySettings
) -> list[tuple[str, float, float]]:
    powers = sorted({s.group for s in series}, key=float)
    head = setup.robot.head_length_m
    return [(p, a, h) for p in powers for a in CANDIDATE_ANGLES_DEG for h in (head, 1.5 * head)]


def _simulate_candidate_trial(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    tuned: JointFit,
    setup: StudySettings,
    condition: tuple[str, float, float],
) -> TrialSeries:
    """A trial of that condition from rest, seen without error, with the usual errors stated."""
    power, angle, length = condition
    like = next(s for s in series if s.group == power)
    times = np.arange(round(NEW_TRIAL_S * NEW_RATE_HZ) + 1) / NEW_RATE_HZ
    inputs = np.tile([np.radians(angle), like.inputs[0, 1]], (len(times), 1))
    stated = np.nanmedian(like.noise[np.isfinite(like.seen).all(axis=1)], axis=0)
    one = replace(
        like,
        times=times,
        inputs=inputs,
        constants=constants_of_robot_trial(setup, length, view=camera_error_inputs(setup)),
        noise=np.tile(stated, (len(times), 1, 1)),
        mean=np.zeros(len(like.mean)),
        evidence={},
        seen=np.zeros((len(times), stated.shape[0])),
    )
    return replace(one, seen=_simulate_states(kernel, one, tuned))


def _simulate_states(kernel: CompiledSystem, series: TrialSeries, tuned: JointFit) -> Float:
    values = tuned.parameter_vectors_by_trial(kernel, [series])[0]
    lanes = [repeat_over_lanes(row[None]) for row in (series.mean, values, series.constants)]
    observed, _ = simulate_batch(
        kernel, *lanes, times=series.times[None], inputs=series.inputs[None]
    )
    return np.ascontiguousarray(observed[0, :, :, 0])
