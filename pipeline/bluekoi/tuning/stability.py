"""Whether a fitted model swims straight: eigenvalues of straight swimming (docs/paper.md)."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from ..fitting import TrialSeries
from ..integrate import LANES, CompiledSystem, System, compile_system
from ..integrate.batch import repeat_over_lanes, simulate_batch
from ..model import constants_of_robot_trial, robot_system, simulate
from ..study import Study, StudySettings
from .joint_fit import JointFit

LINEARISATION_INTERVAL_S = 0.02
"""Interval over which the motion is linearised."""
LINEARISED_STATE_INDICES = (2, 3, 4, 5)  # psi, u, v, r: x and y do not act back


def straight_swimming_growth_per_s(
    coefficients: Mapping[str, float],
    *,
    setup: StudySettings,
    flap_hz: float,
    effects: Mapping[str, Mapping[str, float]] | None = None,
) -> float:
    """Largest real part of the eigenvalues of heading, surge, sway, yaw and the effects' own states
    about straight running.

    The flow over a short span is differenced about the terminal speed; heading alone is neutral.
    NaN where the coefficients give no steady run.
    """
    head = setup.robot.head_length_m
    run = simulate(coefficients, setup=setup, head_length_m=head, head_angle_rad=0.0,
                   flap_hz=flap_hz, duration_s=20.0, effects=effects)  # fmt: skip
    kernel = compile_system(robot_system(setup.robot))
    state = np.zeros((1, len(kernel.system.all_states), LANES))
    state[0, 3] = run.speed_m_s[-1]
    varied = [*LINEARISED_STATE_INDICES, *_effect_state_indices(kernel.system, effects or {})]
    for lane, i in enumerate(varied, start=1):
        state[0, i, lane] += 1e-6
    values = kernel.system.parameter_vector(coefficients, effects)
    _, states = simulate_batch(
        kernel,
        state,
        repeat_over_lanes(values[None]),
        repeat_over_lanes(constants_of_robot_trial(setup, head)[None]),
        times=np.array([[0.0, LINEARISATION_INTERVAL_S]]),
        inputs=np.tile([0.0, flap_hz], (1, 2, 1)),
        keep_states=True,
    )
    end = states[0, 1, varied, :]
    F = (end[:, 1 : 1 + len(varied)] - end[:, :1]) / 1e-6
    if not np.isfinite(F).all():
        return float("nan")
    # the heading's own eigenvalue is 1 (0 per second): leave it out
    return float(np.log(np.max(np.abs(np.linalg.eigvals(F[1:, 1:])))) / LINEARISATION_INTERVAL_S)


def _effect_state_indices(system: System, effects: Collection[str]) -> list[int]:
    """Places of the states of effects, such as the lift of a fin that builds up."""
    return [system.all_states.index(s) for name in effects for s in system.effect(name).states]


MIN_UNSTABLE_GROWTH_PER_S = 0.05
"""Below this a small turn counts as fading."""
MAX_UNSTEADY_DRAWS_SHARE = 0.05
"""Where more of the draws than this have no steady straight run, nothing is asserted."""


def stability_verdict(growth: float, draws: Sequence[float] = ()) -> dict[str, Any]:
    """Eigenvalue with its 95 % range over draws of the fit, and a sentence for the report.

    `stable` is None, and nothing is asserted, where the range holds both answers.
    """
    finite = [float(g) for g in draws if np.isfinite(g)]
    low, high = np.quantile([growth, *finite], [0.025, 0.975]).tolist()
    growth_json = {"eigenvalue_per_s": growth, "interval_95": [low, high] if finite else None}
    lost = 1.0 - (1 + len(finite)) / (1 + len(draws))
    if low <= MIN_UNSTABLE_GROWTH_PER_S < high or lost > MAX_UNSTEADY_DRAWS_SHARE:
        sentence = (
            "Whether the fitted model swims straight is not determined by these trials: within the "
            f"coefficients' deviations a small turn goes as e^({low:+.1f} t) to e^({high:+.1f} t)."
        )
        return growth_json | {"stable": None, "sentence": sentence}
    if growth > MIN_UNSTABLE_GROWTH_PER_S:
        sentence = (
            f"The fitted model does not swim straight: a small turn grows as e^({growth:.1f} t)"
            f"{_interval_text(growth_json)}. A robot that does is steadied by something the model "
            "lacks."
        )
    else:
        sentence = (
            f"The fitted model swims straight: a small turn fades as e^({growth:.1f} t)"
            f"{_interval_text(growth_json)}."
        )
    return growth_json | {"stable": growth <= MIN_UNSTABLE_GROWTH_PER_S, "sentence": sentence}


def undetermined_stability(growth: float) -> dict[str, Any]:
    """Eigenvalue of the fit without a statement: fewer than two turning trials determine it."""
    sentence = (
        "Straight-line stability is undetermined: fewer than two turning trials constrain the yaw "
        "coefficients."
    )
    return {"eigenvalue_per_s": growth, "interval_95": None, "stable": None, "sentence": sentence}


def _interval_text(growth_json: Mapping[str, Any]) -> str:
    if growth_json["interval_95"] is None:
        return ""
    return " (95 %: {:+.1f} to {:+.1f} per second)".format(*growth_json["interval_95"])


MAX_LOG_GROWTH = 6.0
"""Small differences may grow by e^6 = 400 over a segment: from 0.1 mm to 40 mm."""
MIN_HORIZON_S = 1.0
"""For the published robot."""


def predictability_horizon_s(
    study: Study, kernel: CompiledSystem, tuned: JointFit, series: Sequence[TrialSeries]
) -> float:
    """Time in which small differences grow by e^`MAX_LOG_GROWTH` in straight swimming, s."""
    times = [np.inf]
    flap = {s.group: float(s.inputs[-1, 1]) for s in series}
    values = tuned.parameter_vectors_by_trial(kernel, series)
    for group, hz in flap.items():
        point = next(v for s, v in zip(series, values, strict=True) if s.group == group)
        coefficients, effects = kernel.system.unpack_parameter_vector(point)
        growth = straight_swimming_growth_per_s(
            coefficients, setup=study.setup, flap_hz=hz, effects=effects
        )
        if growth > 0:
            times.append(MAX_LOG_GROWTH / growth)
    return max(MIN_HORIZON_S * kernel.system.time_unit_s, min(times))
