"""Errors of a tuned model in the steady speeds and radii of trials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..data import Float, SteadyState
from ..fitting import TrialSeries
from ..integrate import CompiledSystem
from ..model import simulate
from ..study import Study
from .joint_fit import JointFit


def steady_errors(
    study: Study,
    kernel: CompiledSystem,
    tuned: JointFit,
    series: Sequence[TrialSeries],
    steady: Mapping[str, SteadyState],
) -> dict[str, float]:
    """Mean size of the errors in steady radius and speed of trials, %; NaN where there are none."""
    speeds: list[float] = []
    radii: list[float] = []
    for one, values in zip(series, tuned.parameter_vectors_by_trial(kernel, series), strict=True):
        seen = steady.get(one.name)
        if seen is None or seen.quality not in ("good", "short_arc", "straight"):
            continue
        speed, radius = _steady_speed_and_radius(study, kernel, one, seen, values)
        speeds.append(abs(speed / seen.speed_m_s - 1))
        if np.isfinite(seen.radius_m) and seen.quality != "straight" and np.isfinite(radius):
            radii.append(abs(radius / seen.radius_m - 1))
    mean = [100 * float(np.mean(v)) if v else np.nan for v in (radii, speeds)]
    return {"radius_error_pct": mean[0], "speed_error_pct": mean[1]}


def _steady_speed_and_radius(
    study: Study, kernel: CompiledSystem, one: TrialSeries, seen: SteadyState, values: Float
) -> tuple[float, float]:
    """Speed (m/s) and radius (m) of a free run, over the steady segment of the recording."""
    coefficients, effects = kernel.system.unpack_parameter_vector(values)
    trial = study.trial(one.name)
    run = simulate(
        coefficients, setup=study.setup, head_length_m=trial.head_length_m,
        head_angle_rad=trial.head_angle_rad, flap_hz=seen.flap_hz, effects=effects,
        duration_s=max(seen.steady_to_s, 1.0), start=tuple(one.mean[:6].tolist()),
    )  # fmt: skip
    inside = run.time_s >= min(seen.steady_from_s, run.time_s[-2])
    speed = float(run.speed_m_s[inside].mean())
    yaw_rate = abs(float(run.state[inside, 5].mean()))
    return speed, speed / yaw_rate if yaw_rate > 1e-6 else np.inf
