"""What the search must be told of the robot: its variables, its trials to hold out, its errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..data import Float, Steady
from ..fitting import Series
from ..integrate import Kernel
from ..model import simulate
from ..study import Study, Trial
from ..tuning import Tuned
from .locate import MissingForce

HELD_OUT_SHARE = 0.25
CHANNELS = ("surge", "sway", "yaw")


def has_roles(study: Study) -> bool:
    """Whether trials.csv says which trials to hold out."""
    return any(t.role in {"held_out", "fit"} for t in study.trials)


def held_out_trials(study: Study, names: Sequence[str]) -> list[str]:
    """Trials that no fit sees: by `role` where a study gives it, else whole conditions.

    Without roles: conditions (sides together) in the order of power, every fourth of those whose
    power and whose head angle both occur in other conditions as well, never more than a quarter
    of the trials.
    """
    trials = [study.trial(name) for name in names]
    if has_roles(study):
        return [t.trial_id for t in trials if t.role == "held_out"]
    groups: dict[tuple[float, float, float], list[str]] = {}
    for t in trials:
        groups.setdefault((t.power_pct, abs(t.head_angle_deg), t.head_length_m), []).append(
            t.trial_id
        )
    chosen: list[str] = []
    kept = set(groups)
    for key in sorted(groups)[1::3]:
        rest = kept - {key}
        alone = not all(any(other[i] == key[i] for other in rest) for i in range(3))
        if not alone and len(chosen) + len(groups[key]) <= HELD_OUT_SHARE * len(trials) + 0.5:
            kept, chosen = rest, [*chosen, *groups[key]]
    return chosen


def variables(
    series: Sequence[Series], forces: Sequence[MissingForce], trials: Mapping[str, Trial]
) -> list[dict[str, Float]]:
    """What a missing force may depend on, frame by frame, for every trial."""
    return [_variables(s, f, trials[s.name]) for s, f in zip(series, forces, strict=True)]


def _variables(series: Series, force: MissingForce, trial: Trial) -> dict[str, Float]:
    x, y, psi, u, v, r = force.states[:, :6].T
    n = len(x)
    phi = trial.head_angle_rad
    u_h, v_h = u * np.cos(phi) - v * np.sin(phi), u * np.sin(phi) + v * np.cos(phi)
    beat = 2 * np.pi * series.inputs[:, 1] * series.times
    return {
        "speed_m_s": np.hypot(u, v),
        "sway_speed_m_s": v,
        "yaw_rate_rad_s": r,
        "angle_of_attack_rad": -np.arctan2(v_h, np.maximum(np.abs(u_h), 1e-3)),
        "head_angle_rad": np.full(n, phi),
        "flap_hz": series.inputs[:, 1],
        "head_length_m": np.full(n, trial.head_length_m),
        "x_m": x,
        "y_m": y,
        "time_s": series.times,
        "heading_turned_rad": np.abs(psi - psi[0]),
        "tail_beat_phase_rad": np.arctan2(np.sin(beat), np.cos(beat)),
        "side": np.full(n, np.sign(trial.head_angle_deg)),
    }


def steady_errors(
    study: Study,
    kernel: Kernel,
    tuned: Tuned,
    series: Sequence[Series],
    steady: Mapping[str, Steady],
) -> dict[str, float]:
    """Mean size of the errors in steady radius and speed of trials, %; NaN where there are none."""
    speeds: list[float] = []
    radii: list[float] = []
    for one, values in zip(series, tuned.trial_values(kernel, series), strict=True):
        seen = steady.get(one.name)
        if seen is None or seen.quality not in ("good", "short_arc", "straight"):
            continue
        speed, radius = _turn(study, kernel, one, seen, values)
        speeds.append(abs(speed / seen.speed_m_s - 1))
        if np.isfinite(seen.radius_m) and seen.quality != "straight" and np.isfinite(radius):
            radii.append(abs(radius / seen.radius_m - 1))
    mean = [100 * float(np.mean(v)) if v else np.nan for v in (radii, speeds)]
    return {"radius_error_pct": mean[0], "speed_error_pct": mean[1]}


def _turn(
    study: Study, kernel: Kernel, one: Series, seen: Steady, values: Float
) -> tuple[float, float]:
    """Speed (m/s) and radius (m) of a free run, over the stretch in which they were seen."""
    coefficients, effects = split(kernel, values)
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


def split(kernel: Kernel, values: Float) -> tuple[dict[str, float], dict[str, dict[str, float]]]:
    """Coefficients, and the effects that are present with their parameters."""
    names = [p.name for p in kernel.system.parameters]
    given = dict(zip(names, values.tolist(), strict=True))
    coefficients = {k: v for k, v in given.items() if "." not in k}
    effects = {
        e.name: {p.name: given[f"{e.name}.{p.name}"] for p in e.parameters}
        for e in kernel.system.effects
        if any(given[f"{e.name}.{p.name}"] != 0 for p in e.parameters[: e.strengths])
    }
    return coefficients, effects


def best_next_trial(
    study: Study, kernel: Kernel, first: Float, second: Float, flap_hz: Mapping[str, float]
) -> dict[str, object]:
    """Condition in which two fitted models part most in 4 s from rest, in units of path error."""
    found: list[tuple[float, str, float, float]] = []
    lengths = sorted({t.head_length_m for t in study.trials})
    for power, hz in flap_hz.items():
        for angle in (0.0, 15.0, 30.0, 45.0):
            for length in lengths:
                paths = [
                    _path(study, kernel, v, angle=np.radians(angle), length=length, hz=hz)
                    for v in (first, second)
                ]
                apart = float(np.sqrt(np.mean(np.sum((paths[0] - paths[1]) ** 2, axis=1))))
                found.append((apart, power, angle, length))
    apart, power, angle, length = max(found)
    return {
        "power_pct": float(power),
        "head_angle_deg": angle,
        "head_length_m": length,
        "apart_mm": 1000 * apart,
    }


def _path(
    study: Study, kernel: Kernel, values: Float, *, angle: float, length: float, hz: float
) -> Float:
    coefficients, effects = split(kernel, values)
    run = simulate(coefficients, setup=study.setup, head_length_m=length, head_angle_rad=angle,
                   flap_hz=hz, duration_s=4.0, effects=effects)  # fmt: skip
    return run.state[::6, :2]
