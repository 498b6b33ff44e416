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

    condition `(rows,)`: index of the condition a row comes from. names: of the columns. sizes:
    the strength at which each column was differenced.
    """

    y: Float
    columns: Float
    names: tuple[str, ...]
    condition: np.ndarray
    sizes: Float


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
    slopes at strength 0 beside the coefficients `at` (default: all zero).
    """
    zero = kernel.system.values(dict.fromkeys(NAMES, 0.0))
    base = zero if at is None else _with(zero, range(len(NAMES)), at)
    ones = [_with(zero, [k], [1.0]) for k in range(len(NAMES))]
    columns = [_changes(kernel, data, zero, ones)]
    names, sizes = list(NAMES), [1.0] * len(NAMES)
    for effect in effects:
        rows = _strengths(kernel, effect)
        columns.append(_changes(kernel, data, base, [_with(base, [s], [h]) for _, s, h in rows]))
        names += [name for name, _, _ in rows]
        sizes += [size for _, _, size in rows]
    scale = np.std(data.accelerations, axis=0)
    left = (data.accelerations - modelled(kernel, data, [zero])[:, :, 0]) / scale
    stack = np.concatenate(columns, axis=-1) / scale[:, None] / np.array(sizes)
    return Problem(left.ravel(), stack.reshape(left.size, -1), tuple(names),
                   np.repeat(data.condition, 3), np.array(sizes))  # fmt: skip


def _strengths(kernel: Kernel, effect: str) -> list[tuple[str, int, float]]:
    """Name, slot and a small size of each strength of an effect."""
    own, slots = kernel.system.effect(effect), kernel.system.slots(effect)
    return [
        (f"{effect}.{p.name}", slot, 0.1 * abs(p.start) or 1e-3)
        for slot, p in zip(slots, own.parameters[: own.strengths], strict=False)
    ]


def _changes(kernel: Kernel, data: Samples, base: Float, points: Sequence[Float]) -> Float:
    """Accelerations `(n, 3, points)` less those at `base`, which is run beside them.

    Effects by themselves: one that others run beside may be present at strength 0 and yet felt.
    """
    found = modelled(kernel, data, [base, *points])
    return np.asarray(found[:, :, 1:] - found[:, :, :1])


def _with(values: Float, slots: Sequence[int] | range, new: Sequence[float] | Float) -> Float:
    out = values.copy()
    out[list(slots)] = new
    return out
