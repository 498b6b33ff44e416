"""A study as others would regress it: smoothed accelerations against columns of candidate terms.

The columns are those of the search's own candidates: what the compiled model's accelerations
change by when a coefficient or the strength of an effect is added, at the smoothed states.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float, Track
from ..fitting import Series
from ..integrate import LANES, Kernel
from ..integrate.batch import propagate
from ..model import COEFFICIENTS

STEP_S = 1e-3
EVERY = 2
NAMES = tuple(p.name for p in COEFFICIENTS)


@dataclass(frozen=True)
class Problem:
    """Accelerations `(rows,)` of u, v, r over their spread, and columns `(rows, terms)`.

    condition `(rows,)`: index of the condition a row comes from. names: of the columns.
    """

    y: Float
    columns: Float
    names: tuple[str, ...]
    condition: np.ndarray


@dataclass(frozen=True)
class Samples:
    """Smoothed states and accelerations of some trials: (n, 6), (n, 3), and what goes with them."""

    states: Float
    accelerations: Float
    inputs: Float
    constants: Float
    times: Float
    condition: np.ndarray


def samples(series: Sequence[Series], tracks: Mapping[str, Track]) -> Samples:
    """Every `EVERY`-th smoothed state of the trials, accelerations by differences of the rates."""
    names = sorted({s.condition for s in series})
    parts = [_trial_samples(s, tracks[s.name], names.index(s.condition)) for s in series]
    return Samples(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _trial_samples(series: Series, track: Track, condition: int) -> tuple[np.ndarray, ...]:
    psi = track.heading_rad
    u = track.vx_m_s * np.cos(psi) + track.vy_m_s * np.sin(psi)
    v = track.vy_m_s * np.cos(psi) - track.vx_m_s * np.sin(psi)
    states = np.column_stack([track.x_m, track.y_m, psi, u, v, track.yaw_rate_rad_s])
    slopes = np.gradient(states[:, 3:], track.time_s, axis=0)
    known = np.all(np.isfinite(states), axis=1) & np.all(np.isfinite(slopes), axis=1)
    chosen = np.flatnonzero(known)[::EVERY]
    n = len(chosen)
    return (states[chosen], slopes[chosen], np.tile(series.inputs[0], (n, 1)),
            np.tile(series.constants, (n, 1)), track.time_s[chosen] - track.time_s[0],
            np.full(n, condition))  # fmt: skip


def modelled(kernel: Kernel, data: Samples, values: Sequence[Float]) -> Float:
    """Accelerations `(n, 3, points)` that the model gives at the samples for parameter vectors."""
    n = len(data.times)
    state = np.zeros((n, len(kernel.system.all_states), LANES))
    state[:, :6] = data.states[:, :, None]
    times = np.column_stack([data.times, data.times + STEP_S])
    inputs = np.repeat(data.inputs[:, None, :], 2, axis=1)
    constants = np.repeat(data.constants[:, :, None], LANES, axis=2)
    out = np.empty((n, 3, len(values)))
    for first in range(0, len(values), LANES):
        some = np.array(values[first : first + LANES])
        padded = np.concatenate([some, np.repeat(some[-1:], LANES - len(some), axis=0)])
        block = np.repeat(padded.T[None], n, axis=0)
        _, found = propagate(kernel, state, block, constants, times=times, inputs=inputs,
                             keep_states=True, step_s=STEP_S)  # fmt: skip
        change = (found[:, 1, 3:6] - state[:, 3:6]) / STEP_S
        out[:, :, first : first + LANES] = change[:, :, : len(some)]
    return out


def problem(kernel: Kernel, data: Samples, effects: Sequence[str], at: Float | None) -> Problem:
    """Columns of the six coefficients and of each strength of the effects, differenced at `at`.

    The coefficients' columns are exact (the model is linear in them); those of the effects are
    slopes at strength 0 beside the coefficients `at` (default: those of the effects' absence).
    """
    system = kernel.system
    zero = system.values(dict.fromkeys(NAMES, 0.0))
    base = zero if at is None else _with(zero, range(len(NAMES)), at)
    points, names = [zero, base], []
    for k, name in enumerate(NAMES):
        points.append(_with(zero, [k], [1.0]))
        names.append(name)
    sizes = [1.0] * len(NAMES)
    for effect in effects:
        own = system.effect(effect)
        for slot, p in list(zip(system.slots(effect), own.parameters, strict=True))[
            : own.strengths
        ]:
            size = 0.1 * abs(p.start) or 1e-3
            points.append(_with(base, [slot], [size]))
            names.append(f"{effect}.{p.name}")
            sizes.append(size)
    found = modelled(kernel, data, points)
    from_zero = [found[:, :, 2 + k] - found[:, :, 0] for k in range(len(NAMES))]
    from_base = [found[:, :, k] - found[:, :, 1] for k in range(2 + len(NAMES), len(points))]
    scale = np.std(data.accelerations, axis=0)
    stack = np.stack([*from_zero, *from_base], axis=-1) / scale[:, None]
    left = (data.accelerations - found[:, :, 0]) / scale
    return Problem(left.ravel(), stack.reshape(left.size, -1) / np.array(sizes), tuple(names),
                   np.repeat(data.condition, 3))  # fmt: skip


def _with(values: Float, slots: Sequence[int] | range, new: Sequence[float] | Float) -> Float:
    out = values.copy()
    out[list(slots)] = new
    return out
