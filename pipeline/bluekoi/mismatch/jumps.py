"""Moments at which everything seen was displaced at once: a camera that was knocked.

Nothing that swims jumps, so a jump needs no model of what is lacking. For every moment of a trial
the displacement from then on that suits the filter's prediction errors e best is found (Willsky and
Jones, IEEE Trans. Automatic Control 21 (1976), 108),

    J = de / d(displacement),   lambda = (J'e)' (J'J)^-1 (J'e),

by what remains of it in the whitened errors after the filter has followed it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..fitting import Filtered, Noise, Series, filter_all
from ..fitting.filtering import STEP_S, with_noise
from ..integrate import LANES, Kernel
from ..integrate.batch import propagate

EFFECT, MOMENT, BESIDE = "camera_shift", "t_shift", ("x_shift", "y_shift")
SIDES = ("dx", "dy")
STEP_M = 1e-3
USUAL = 1.386
"""Median of chi-squared with two degrees of freedom."""
PRIOR = 0.03
"""Probability that the camera was displaced in a study, as of any other cause."""
TAIL = 1.5
"""Largest lambda of 290 recordings without a jump, 31, over that of chi-squared in as many moments,
2 log(29,000): prediction errors have longer tails than a normal distribution.
"""
LAUNCH_S = 0.8
"""From a trial's start on so long all paths bend at once, and a form that the model lacks looks
like a jump: a motor that spins up, beside three causes and in no other form, did with 105.
"""


@dataclass(frozen=True)
class Jump:
    """A jump in one trial: time_s, displacement (2,) m, and how sure, lambda over the usual.

    moments: from how many the time was chosen.
    """

    trial: str
    time_s: float
    displacement: Float
    ratio: float
    moments: int


def jumps(
    kernel: Kernel, series: Sequence[Series], values: Sequence[Float], noise: Noise
) -> list[Jump]:
    """The surest jump of each trial in which one is more probable than not, around a fitted model;
    trials of fewer than eight frames have none.

    With M moments and n trials, a jump at one of them has odds of
    PRIOR (n M)^-TAIL exp(lambda / 2).

    values: full parameter vectors, one a trial.
    """
    passed = filter_all(kernel, series, values, noise)
    long = [(s, v, p) for s, v, p in zip(series, values, passed, strict=True) if len(_moments(s))]
    if not long:
        return []
    series = [one for one, _, _ in long]
    told = [_told(kernel, *one, noise) for one in long]
    usual = max(1.0, float(np.median(np.concatenate([t[0] for t in told]))) / USUAL)
    out = []
    for one, (ratio, size) in zip(series, told, strict=True):
        k = int(np.argmax(ratio))
        likely = 2.0 * (TAIL * np.log(len(series) * len(ratio)) - np.log(PRIOR))
        if ratio[k] / usual > likely:
            out.append(Jump(one.name, float(_moments(one)[k]), size[k], float(ratio[k] / usual),
                            len(ratio)))  # fmt: skip
    return out


def with_jumps(kernel: Kernel, series: Sequence[Series], found: Sequence[Jump]) -> list[Series]:
    """The trials, told at which moment each was displaced, and how beside the surest of them."""
    names, known = kernel.system.constants, {j.trial: j for j in found}
    slots = [names.index(name) for name in (MOMENT, *BESIDE)]
    surest = complex(*max(found, key=lambda j: j.ratio).displacement) if found else 1.0
    out = []
    for one in series:
        constants = one.constants.copy()
        if jump := known.get(one.name):
            beside = complex(*jump.displacement) / surest
            constants[slots] = jump.time_s, beside.real, beside.imag
        out.append(replace(one, constants=constants))
    return out


def _moments(one: Series) -> Float:
    """Middles between frames, not too near the ends, after the launch."""
    middles = 0.5 * (one.times[3:-3] + one.times[4:-2])
    later = middles[middles > one.times[0] + LAUNCH_S]
    return later if len(later) else middles


def _told(
    kernel: Kernel, one: Series, values: Float, passed: Filtered, noise: Noise
) -> tuple[Float, Float]:
    """The lambda (moments,) and best displacement (moments, 2) of a trial."""
    moments = _moments(one)
    seen = _displaced(kernel, one, values, passed, noise=noise, moments=moments)
    base = seen[:, :, :1]
    J = passed.roots @ ((seen[:, :, 1:] - base) / STEP_M)  # (n, o, 2 moments)
    e = (passed.roots @ np.nan_to_num(one.seen[:, :, None] - base))[:, :, 0]
    J = J.reshape(*J.shape[:2], len(moments), 2)
    H = np.einsum("nomi,nomj->mij", J, J) + 1e-9 * np.eye(2)
    g = np.einsum("nomi,no->mi", J, e)
    best = np.linalg.solve(H, g[:, :, None])[:, :, 0]
    return np.einsum("mi,mi->m", g, best), best


def _displaced(
    kernel: Kernel, one: Series, values: Float, passed: Filtered, *, noise: Noise, moments: Float
) -> Float:
    """Predicted observations (n, o, 1 + 2 moments): as fitted, then each moment's displacements."""
    each = (LANES - 1) // 2
    groups = [moments[i : i + each] for i in range(0, len(moments), each)]
    system, count, n = kernel.system, len(groups), len(one.times)
    full = np.repeat(with_noise(kernel, values, noise)[:, None], LANES, axis=1)
    parameters = np.repeat(full[None], count, axis=0)
    constants = np.repeat(np.repeat(one.constants[:, None], LANES, axis=1)[None], count, axis=0)
    state = np.repeat(np.repeat(one.mean[:, None], LANES, axis=1)[None], count, axis=0)
    for b, group in enumerate(groups):
        for i, moment in enumerate(group):
            for k, side in enumerate(SIDES):
                lane = 1 + 2 * i + k
                parameters[b, system.slot[f"{EFFECT}.{side}"], lane] += STEP_M
                constants[b, system.constants.index(MOMENT), lane] = moment
    tiled = [np.repeat(a[None], count, axis=0) for a in (one.times, one.inputs,
             np.nan_to_num(one.seen), passed.gains)]  # fmt: skip
    seen, _ = propagate(kernel, state, parameters, constants, times=tiled[0], inputs=tiled[1],
                        frames=np.full(count, n), seen=tiled[2], gains=tiled[3],
                        step_s=STEP_S)  # fmt: skip
    lanes = [seen[b, :, :, 1 : 1 + 2 * len(group)] for b, group in enumerate(groups)]
    return np.concatenate([seen[0, :, :, :1], *lanes], axis=2)
