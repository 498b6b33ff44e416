"""Law of each named cause: its force over the variable that describes it best, with a band."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ..data import Float
from ..fitting import (
    Z_95,
    MissingForce,
    Noise,
    TrialSeries,
    force_of_added_effects,
    missing_force,
    parameter_index_by_name,
)
from ..integrate import CompiledSystem
from ..study import Trial
from ..tuning import JointFit
from .missing_force_dependence import FORCE_CHANNELS, covariates

BIN_COUNT, MIN_FRAMES_PER_BIN = 15, 3
PARTS_PER_TRIAL = 8
"""Parts of a trial over which its partial residuals are averaged, about a second each: a choice for
the figure of the laws, without a part in the verdict."""
CHANNEL_UNITS = ("N", "N", "N m")
VARIABLES_OF_EFFECT: Mapping[str, tuple[str, ...]] = {
    "angle of attack": ("angle_of_attack_rad",),
    "angle turned": ("heading_turned_rad",),
    "beat": ("flap_hz",),
    "distance from a point": ("x_m", "y_m"),
    "distance from the start": ("x_m", "y_m"),
    "drift": ("sway_speed_m_s",),
    "early": ("time_s",),
    "head angle": ("head_angle_rad",),
    "head length": ("head_length_m",),
    "heading turned": ("heading_turned_rad",),
    "place": ("x_m", "y_m"),
    "side": ("side", "head_angle_rad"),
    "speed": ("speed_m_s",),
    "speed, to one side": ("speed_m_s",),
    "time": ("time_s",),
    "turn": ("yaw_rate_rad_s",),
}
"""What an effect depends on -> variables of `covariates` over which its law may be drawn."""
DERIVATIVE_STEP_STDS = 0.1
"""Step of the derivatives with respect to a parameter, in its standard deviations."""


@dataclass(frozen=True)
class EqualCountBins:
    """Frames sorted into bins of equal count over one variable: index (frames,), means (bins,)."""

    index: np.ndarray
    x: Float

    def means(self, values: Float) -> Float:
        """Mean of values (frames,) in each bin."""
        return np.array([values[self.index == k].mean() for k in range(len(self.x))])


def cause_force_curves(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    forces: Sequence[MissingForce],
    tuned: JointFit,
    trials: Mapping[str, Trial],
) -> dict[str, dict[str, Any]]:
    """Law of every cause in a tuned model that exerts a force.

    The force is that of the cause alone along the smoothed paths, in the channel where it is
    largest against the random force, averaged over bins of the variable that explains most of it;
    channels and variables are those that the effect names.
    Each: variable, x (bins,), y, low, high (95 % band by the covariance of the cause's numbers;
    empty where one of them is not known), channel, y_unit, explained (share of its variance).
    """
    known = covariates(series, forces, trials)
    over = {name: np.concatenate([v[name] for v in known]) for name in known[0]}
    names = dict.fromkeys(f.name.split(".")[0] for f in tuned.fit.free if "." in f.name)
    found = {name: _cause_force_curve(kernel, series, tuned, name, over) for name in names}
    return {name: law for name, law in found.items() if law}


def partial_residuals(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    forces: Sequence[MissingForce],
    tuned: JointFit,
    trials: Mapping[str, Trial],
    *,
    laws: Mapping[str, Mapping[str, Any]],
    noise: Noise,
) -> dict[str, dict[str, dict[str, Float]]]:
    """Cause -> trial -> `x`, `y` and `cause_force` (parts,): data with which the law is compared.

    y is the partial residual: the force that the model with all causes still lacks, smoothed with
    the random forces of `noise`, plus the cause's own force, which is also given alone. x is the
    variable of the law. All are means over equal parts of a trial.
    """
    left = missing_force(kernel, series, tuned.parameter_vectors_by_trial(kernel, series), noise)
    known = covariates(series, forces, trials)
    ends = np.cumsum([len(one.times) for one in series])[:-1]
    found: dict[str, dict[str, dict[str, Float]]] = {}
    for name, law in laws.items():
        channel = FORCE_CHANNELS.index(law["channel"])
        own = np.split(
            _cause_force(kernel, series, tuned, name, tuned.fit.values)[:, channel], ends
        )
        found[name] = {
            rest.name: {"x": _means_over_trial_parts(over[law["variable"]]),
                        "y": _means_over_trial_parts(rest.force[:, channel] + push),
                        "cause_force": _means_over_trial_parts(push)}
            for rest, over, push in zip(left, known, own, strict=True)
        }  # fmt: skip
    return found


def _means_over_trial_parts(values: Float) -> Float:
    return np.array(
        [part.mean() for part in np.array_split(values, min(PARTS_PER_TRIAL, len(values)))]
    )


def _cause_force_curve(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    tuned: JointFit,
    name: str,
    over: Mapping[str, Float],
) -> dict[str, Any] | None:
    own = [i for i, f in enumerate(tuned.fit.free) if f.name.startswith(f"{name}.")]
    force = partial(_cause_force, kernel, series, tuned, name)
    every = force(tuned.fit.values)
    units = tuned.noise.disturbance[: every.shape[1]]
    shares = np.sqrt((every**2).mean(axis=0)) / np.maximum(units, 1e-12)
    effect = kernel.system.effect(name)
    stated = [i for i, c in enumerate(FORCE_CHANNELS[: len(shares)]) if c in effect.channels]
    channel = max(stated or range(len(shares)), key=lambda i: float(shares[i]))
    y = every[:, channel]
    if not np.isfinite(y).all() or np.ptp(y) == 0.0:
        return None
    named = {v for kind in effect.variables for v in VARIABLES_OF_EFFECT.get(kind, ())}
    binned = {v: b for v, x in over.items()
              if (v in named or not named) and (b := equal_count_bins(x)) is not None}  # fmt: skip
    explained = {v: _share_explained_by_bins(b, y) for v, b in binned.items()}
    if not explained:
        return None
    variable = max(explained, key=lambda v: explained[v])
    grid = binned[variable]
    mean = grid.means(y)
    half = _half_width_95(tuned, own, lambda at: grid.means(force(at)[:, channel]), mean)
    law: dict[str, Any] = {
        "variable": variable, "x": grid.x, "y": mean, "channel": FORCE_CHANNELS[channel],
        "y_unit": CHANNEL_UNITS[channel], "explained": explained[variable], "low": [], "high": [],
    }  # fmt: skip
    return law if half is None else law | {"low": mean - half, "high": mean + half}


def _cause_force(
    kernel: CompiledSystem, series: Sequence[TrialSeries], tuned: JointFit, name: str, values: Float
) -> Float:
    """Force (frames, channels) of one cause along all trials, with these fitted numbers."""
    free, slots = tuned.fit.free, parameter_index_by_name(kernel)
    on = []
    for one in series:
        point = tuned.base.copy()
        for item, value in zip(free, values, strict=True):
            if item.group in (None, one.group):
                point[slots[item.name]] = value
        on.append(point)
    off = [point.copy() for point in on]
    effect = kernel.system.effect(name)
    for point in off:
        for parameter in effect.parameters[: effect.strengths]:
            point[slots[f"{name}.{parameter.name}"]] = 0.0
    return np.concatenate(force_of_added_effects(kernel, series, on, off, tuned.noise))


def equal_count_bins(x: Float) -> EqualCountBins | None:
    """Bins of about equal count over the values of a variable; one for each value of a variable
    with few; None for a constant one.
    """
    values = np.unique(x)
    if len(values) < 2 or not np.isfinite(x).all():
        return None
    if len(values) <= BIN_COUNT:
        index = np.searchsorted(values, x)
    else:
        edges = np.unique(np.quantile(x, np.linspace(0, 1, BIN_COUNT + 1)[1:-1]))
        index = np.searchsorted(edges, x, side="right")
    kept = [k for k in np.unique(index) if np.sum(index == k) >= MIN_FRAMES_PER_BIN]
    if len(kept) < 2:
        return None
    place = np.full(int(index.max()) + 1, -1)
    place[kept] = np.arange(len(kept))
    new = place[index]
    return EqualCountBins(new, np.array([x[new == k].mean() for k in range(len(kept))]))


def _share_explained_by_bins(binned: EqualCountBins, y: Float) -> float:
    """Share of the mean square of y that the means of the bins explain."""
    inside = binned.index >= 0
    left = y[inside] - binned.means(y)[binned.index[inside]]
    return float(1.0 - np.mean(left**2) / max(float(np.mean(y[inside] ** 2)), 1e-300))


def _half_width_95(tuned: JointFit, own: Sequence[int], law: Any, mean: Float) -> Float | None:
    """Half width of the 95 % band (bins,), linear in the cause's numbers; None where one of their
    deviations is unknown. A number at its bound does not vary.
    """
    half = 0.5 * np.diff(tuned.interval_95, axis=1)[:, 0] / Z_95
    moved = [i for i in own if tuned.cov[i, i] > 0]
    if not moved or not np.isfinite(half[moved]).all():
        return None
    columns = []
    for i in moved:
        at = tuned.fit.values.copy()
        at[i] += DERIVATIVE_STEP_STDS * half[i]
        columns.append((law(at) - mean) / (DERIVATIVE_STEP_STDS * half[i]))
    J = np.array(columns).T
    own_std = np.sqrt(np.diag(tuned.cov)[moved])
    correlation = tuned.cov[np.ix_(moved, moved)] / np.outer(own_std, own_std)
    cov = correlation * np.outer(half[moved], half[moved])
    return Z_95 * np.sqrt(np.maximum(np.einsum("bi,ij,bj->b", J, cov, J), 0.0))
