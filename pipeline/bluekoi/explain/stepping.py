"""Time constants of a model along its trials, and what follows for sampling and integration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data import Float
from ..fitting import FilterResults, Noise, TrialSeries, filter_all
from ..fitting.filtering import MAX_FILTER_STEP_S
from ..integrate import LANES, CompiledSystem
from ..integrate.batch import repeat_over_lanes, simulate_batch

RATE_INTERVAL_S, STATE_DIFFERENCE = 1e-6, 1e-4
"""Interval over which a rate is taken, s, and difference of a state in its standard deviations."""
MAX_LINEARISATION_POINTS = 200
"""Points of the trials at which time constants are computed, at most."""
MAX_STEP_OVER_TIME_CONSTANT = 1.0
"""Runge and Kutta's fourth-order step is stable up to 2.78 time constants, and exact to 0.007 of a
decay over one. What that does to a likelihood is checked
(`log_likelihood_change_by_finer_step`)."""
DEFAULT_MAX_INTEGRATION_STEP_S = 0.5
"""Longest integration step, s, of a model without fast dynamics."""
MAX_LOG_LIKELIHOOD_CHANGE = 0.5
"""Log likelihood that a step of half the length may change."""


def fastest_rates_per_s(
    kernel: CompiledSystem, passes: FilterResults, values: Sequence[Float]
) -> Float:
    """Largest |eigenvalue| (states visited,), 1/s, of the model's own states along trials."""
    out = []
    each = max(1, MAX_LINEARISATION_POINTS // max(len(passes), 1))
    for one, result, value in zip(passes.series, passes, values, strict=True):
        frames = np.unique(
            np.linspace(0, len(one.times) - 1, min(each, len(one.times))).astype(int)
        )
        slopes = state_jacobians(kernel, one, result.filtered[frames], value, frames)
        out.append(_largest_eigenvalues(slopes))
    return np.concatenate([*out, np.zeros(1)])


def longest_step_at_start_s(
    kernel: CompiledSystem, series: Sequence[TrialSeries], values: Float
) -> float:
    """Integration step for the initial states of trials, before any state is filtered."""
    first = np.zeros(1, dtype=int)
    slopes = [state_jacobians(kernel, one, one.mean[None], values, first) for one in series]
    rates = _largest_eigenvalues(np.concatenate(slopes))
    return min(MAX_FILTER_STEP_S, longest_step_s(float(rates.max(initial=0.0))))


def _largest_eigenvalues(slopes: Float) -> Float:
    """Largest |eigenvalue| of each matrix (n, s, s) that is finite."""
    usable = slopes[np.isfinite(slopes).all(axis=(1, 2))]
    return np.abs(np.linalg.eigvals(usable)).max(axis=1) if len(usable) else np.zeros(0)


def state_jacobians(
    kernel: CompiledSystem, one: TrialSeries, states: Float, values: Float, frames: np.ndarray
) -> Float:
    """Slopes (frames, own states, own states) of the rates of change by the model's own states."""
    own = len(kernel.system.states)
    out = np.zeros((len(frames), own, own))
    fixed = [repeat_over_lanes(np.tile(row, (len(frames), 1))) for row in (values, one.constants)]
    for first in range(0, own, LANES - 1):
        columns = range(first, min(own, first + LANES - 1))
        lanes = repeat_over_lanes(states)
        for lane, k in enumerate(columns, start=1):
            lanes[:, k, lane] += STATE_DIFFERENCE
        _, after = simulate_batch(
            kernel, lanes, *fixed,
            times=one.times[frames, None] + np.array([0.0, RATE_INTERVAL_S]), keep_states=True,
            inputs=np.repeat(one.inputs[frames, None], 2, axis=1), step_s=1.0,
        )  # fmt: skip
        moved = (after[:, 1, :own] - lanes[:, :own]) - (after[:, 1, :own, :1] - lanes[:, :own, :1])
        for lane, k in enumerate(columns, start=1):
            out[:, :, k] = moved[:, :, lane] / (STATE_DIFFERENCE * RATE_INTERVAL_S)
    return out


def longest_step_s(rate_per_s: float) -> float:
    """Integration step for a model whose fastest time constant is 1 / rate."""
    return float(
        min(DEFAULT_MAX_INTEGRATION_STEP_S, MAX_STEP_OVER_TIME_CONSTANT / max(rate_per_s, 1e-9))
    )


def log_likelihood_change_by_finer_step(
    coarse: CompiledSystem,
    fine: CompiledSystem,
    series: Sequence[TrialSeries],
    values: Sequence[Float],
    noise: Noise,
) -> float:
    """Change of the log likelihood by a finer integration step."""
    both = [sum(f.log_likelihood for f in filter_all(k, series, values, noise))
            for k in (coarse, fine)]  # fmt: skip
    return float(abs(both[1] - both[0]))
