"""Times at which all positions were displaced at once, because the camera was moved.

A swimming body does not jump; a level shift of the positions can therefore be detected without
knowing which physics is missing. For every time of a trial, the displacement from then on that fits
the filter's prediction errors e best has the generalised likelihood ratio (Willsky and Jones, IEEE
Trans. Automatic Control 21 (1976), 108)

    J = de / d(displacement),   lambda = (J'e)' (J'J)^-1 (J'e),

with J what remains of it in the whitened errors after the filter has followed it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import FilteredTrial, Noise, TrialSeries, filter_all
from ..fitting.filtering import MAX_FILTER_STEP_S, parameters_with_random_effects_on
from ..integrate import LANES, CompiledSystem
from ..integrate.batch import simulate_batch

CAMERA_SHIFT_EFFECT, SHIFT_TIME_NAME, SHIFT_SIZE_NAMES = (
    "camera_shift",
    "t_shift",
    ("x_shift", "y_shift"),
)
DISPLACEMENT_PARAMETERS = ("dx", "dy")
DERIVATIVE_STEP_M = 1e-3
CHI2_2_DF_MEDIAN = 1.386
"""Median of chi-squared with two degrees of freedom, 2 log 2."""
DISPLACEMENT_PRIOR_PROBABILITY = 0.03
"""Probability that the camera was displaced in a study, as of any other cause."""
NULL_DISTRIBUTION_TAIL_FACTOR = 1.5
"""Largest lambda of 290 recordings without a displacement, 31, over that of chi-squared in as many
moments, 2 log(29,000): prediction errors have longer tails than a normal distribution.
"""
IGNORED_AFTER_START_S = 0.8
"""Duration after the start of a trial, for the published robot, in which all paths bend at once, so
that missing physics looks like a displacement: a motor that spins up, beside three other causes,
reached lambda = 105.
"""


@dataclass(frozen=True)
class CameraDisplacement:
    """A displacement in one trial: time_s, size (2,) m, and lambda over its median without one.

    moments: number of moments among which the time was chosen.
    """

    trial: str
    time_s: float
    size_m: Float
    likelihood_ratio: float
    moments: int


def detect_displacements(
    kernel: CompiledSystem, series: Sequence[TrialSeries], values: Sequence[Float], noise: Noise
) -> list[CameraDisplacement]:
    """The most certain displacement of each trial in which one is more probable than not, around a
    fitted model; trials of fewer than eight frames have none.

    With M moments and n trials, a displacement at one of them has odds of
    DISPLACEMENT_PRIOR_PROBABILITY (n M)^-NULL_DISTRIBUTION_TAIL_FACTOR exp(lambda / 2).

    values: full parameter vectors, one a trial.
    """
    filtered, unit = filter_all(kernel, series, values, noise), kernel.system.time_unit_s
    long = [
        (s, v, f)
        for s, v, f in zip(series, values, filtered, strict=True)
        if len(_tested_times_s(s, unit))
    ]
    if not long:
        return []
    glr = [_level_shift_glr(kernel, *one, noise) for one in long]
    median = max(1.0, float(np.median(np.concatenate([g[0] for g in glr]))) / CHI2_2_DF_MEDIAN)
    out = []
    for (one, _, _), (ratio, size) in zip(long, glr, strict=True):
        k = int(np.argmax(ratio))
        threshold = 2.0 * (
            NULL_DISTRIBUTION_TAIL_FACTOR * np.log(len(long) * len(ratio))
            - np.log(DISPLACEMENT_PRIOR_PROBABILITY)
        )
        if ratio[k] / median > threshold:
            out.append(CameraDisplacement(one.name, float(_tested_times_s(one, unit)[k]), size[k],
                                          float(ratio[k] / median), len(ratio)))  # fmt: skip
    return out


def with_displacement_constants(
    kernel: CompiledSystem, series: Sequence[TrialSeries], found: Sequence[CameraDisplacement]
) -> list[TrialSeries]:
    """The trials with the time of their displacement, and its size relative to the most certain."""
    names, known = kernel.system.constants, {d.trial: d for d in found}
    slots = [names.index(name) for name in (SHIFT_TIME_NAME, *SHIFT_SIZE_NAMES)]
    largest = max(found, key=lambda d: d.likelihood_ratio, default=None)
    out = []
    for one in series:
        constants = one.constants.copy()
        if largest and (own := known.get(one.name)):
            relative = complex(*own.size_m) / complex(*largest.size_m)
            constants[slots] = own.time_s, relative.real, relative.imag
        out.append(replace(one, constants=constants))
    return out


def _tested_times_s(one: TrialSeries, time_unit_s: float) -> Float:
    """Middles between frames, not too near the ends, after the launch."""
    middles = 0.5 * (one.times[3:-3] + one.times[4:-2])
    later = middles[middles > one.times[0] + IGNORED_AFTER_START_S * time_unit_s]
    return later if len(later) else middles


def _level_shift_glr(
    kernel: CompiledSystem, one: TrialSeries, values: Float, filtered: FilteredTrial, noise: Noise
) -> tuple[Float, Float]:
    """The lambda (moments,) and best displacement (moments, 2) of a trial."""
    moments = _tested_times_s(one, kernel.system.time_unit_s)
    seen = _predictions_with_displacements(
        kernel, one, values, filtered, noise=noise, moments=moments
    )
    base = seen[:, :, :1]
    J = filtered.roots @ ((seen[:, :, 1:] - base) / DERIVATIVE_STEP_M)  # (n, o, 2 moments)
    e = (filtered.roots @ np.nan_to_num(one.seen[:, :, None] - base))[:, :, 0]
    J = J.reshape(*J.shape[:2], len(moments), 2)
    H = np.einsum("nomi,nomj->mij", J, J) + 1e-9 * np.eye(2)
    g = np.einsum("nomi,no->mi", J, e)
    best = np.linalg.solve(H, g[:, :, None])[:, :, 0]
    return np.einsum("mi,mi->m", g, best), best


def _predictions_with_displacements(
    kernel: CompiledSystem,
    one: TrialSeries,
    values: Float,
    filtered: FilteredTrial,
    *,
    noise: Noise,
    moments: Float,
) -> Float:
    """Predicted observations (n, o, 1 + 2 moments): as fitted, then each moment's displacements."""
    each = (LANES - 1) // 2
    groups = [moments[i : i + each] for i in range(0, len(moments), each)]
    system, count, n = kernel.system, len(groups), len(one.times)
    full = np.repeat(
        parameters_with_random_effects_on(kernel, values, noise)[:, None], LANES, axis=1
    )
    parameters = np.repeat(full[None], count, axis=0)
    constants = np.repeat(np.repeat(one.constants[:, None], LANES, axis=1)[None], count, axis=0)
    state = np.repeat(np.repeat(one.mean[:, None], LANES, axis=1)[None], count, axis=0)
    for b, group in enumerate(groups):
        for i, moment in enumerate(group):
            for k, direction in enumerate(DISPLACEMENT_PARAMETERS):
                lane = 1 + 2 * i + k
                parameters[
                    b, system.parameter_index[f"{CAMERA_SHIFT_EFFECT}.{direction}"], lane
                ] += DERIVATIVE_STEP_M
                constants[b, system.constants.index(SHIFT_TIME_NAME), lane] = moment
    tiled = [np.repeat(a[None], count, axis=0) for a in (one.times, one.inputs,
             np.nan_to_num(one.seen), filtered.gains)]  # fmt: skip
    seen, _ = simulate_batch(kernel, state, parameters, constants, times=tiled[0], inputs=tiled[1],
                             frames=np.full(count, n), seen=tiled[2], gains=tiled[3],
                             step_s=system.longest_step_s(MAX_FILTER_STEP_S))  # fmt: skip
    lanes = [seen[b, :, :, 1 : 1 + 2 * len(group)] for b, group in enumerate(groups)]
    return np.concatenate([seen[0, :, :, :1], *lanes], axis=2)
