"""Free-running simulations from the starting state that suits each trial best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import LANES, Kernel
from ..integrate.batch import propagate
from .series import Series


@dataclass(frozen=True)
class Shot:
    """Free run of one trial: start (states,), states (n, states), observed (n, observations).

    rmse: root mean square of the distance between seen and simulated over the first two
    observations (a path, m, where they are x and y).
    """

    start: Float
    states: Float
    observed: Float
    rmse: float


def shoot(
    kernel: Kernel,
    series: Sequence[Series],
    values: Sequence[Float],
    *,
    open_states: int = 6,
    iterations: int = 8,
) -> list[Shot]:
    """A `Shot` a trial; the first `open_states` of the start are fitted (damped Gauss-Newton).

    The start's prior is that of the series; all trials advance together. First a quarter of each
    trial is fitted, then half, then all of it: an unstable model that would run away from a rough
    start is led to a fine one.
    """
    starts = np.array([s.mean for s in series])
    for share in SHARES:
        part = [first_part(s, share) for s in series]
        starts = _fitted_starts(kernel, part, values, starts, count=open_states,
                                iterations=iterations)  # fmt: skip
    observed, states = _run(kernel, series, values, starts, open_states)
    return [
        Shot(x, run[: len(s.times), :, 0], o[: len(s.times), :, 0], _rmse(s, o[:, :, 0]))
        for s, x, run, o in zip(series, starts, states, observed, strict=True)
    ]


SHARES = (0.25, 0.5, 1.0)


def first_part(series: Series, share: float) -> Series:
    """The first share of a trial's frames, two at least."""
    n = max(2, int(np.ceil(share * len(series.times))))
    return series.frames(0, n)


def _fitted_starts(
    kernel: Kernel,
    series: Sequence[Series],
    values: Sequence[Float],
    starts: Float,
    *,
    count: int,
    iterations: int,
) -> Float:
    """Starts (trials, states) from which each trial's run is closest to what was seen."""
    starts = starts.copy()
    observed, _ = _run(kernel, series, values, starts, count)
    damping = np.full(len(series), 1e-3)
    cost = _costs(series, observed, starts)
    for _ in range(iterations):
        steps = [
            _step(s, o, x, count, d)
            for s, o, x, d in zip(series, observed, starts, damping, strict=True)
        ]
        trial = starts + np.array(steps)
        seen, _ = _run(kernel, series, values, trial, count)
        new = _costs(series, seen, trial)
        with np.errstate(invalid="ignore"):  # both infinite: not settled
            settled = np.abs(cost - new) <= 1e-6 * cost
        better = new <= cost
        damping = np.where(better, damping * 0.2, damping * 10.0)
        starts[better], cost[better], observed[better] = trial[better], new[better], seen[better]
        if settled.all():
            break
    return starts


def _costs(series: Sequence[Series], observed: Float, starts: Float) -> Float:
    """Cost (trials,) of each run; infinite where it runs away."""
    with np.errstate(over="ignore", invalid="ignore"):
        found = [_cost(s, o[:, :, 0], x) for s, o, x in zip(series, observed, starts, strict=True)]
    return np.where(np.isfinite(found), found, np.inf)


STEPS = np.array([1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4])


def _run(
    kernel: Kernel, series: Sequence[Series], values: Sequence[Float], starts: Float, count: int
) -> tuple[Float, Float]:
    longest = max(len(s.times) for s in series)
    times = np.array([np.pad(s.times, (0, longest - len(s.times)), mode="edge") for s in series])
    inputs = np.array(
        [np.pad(s.inputs, ((0, longest - len(s.times)), (0, 0)), mode="edge") for s in series]
    )
    state = np.repeat(starts[:, :, None], LANES, axis=2)
    for i in range(count):
        state[:, i, i + 1] += STEPS[min(i, len(STEPS) - 1)]
    return propagate(
        kernel,
        state,
        np.repeat(np.array(values)[:, :, None], LANES, axis=2),
        np.repeat(np.array([s.constants for s in series])[:, :, None], LANES, axis=2),
        times=times,
        inputs=inputs,
        frames=np.array([len(s.times) for s in series]),
        keep_states=True,
    )


def _errors(series: Series, observed: Float) -> Float:
    """Seen minus simulated over the stated deviation, 0 where missing: (n, observations)."""
    error = series.seen - observed[: len(series.times)]
    error = np.where(np.isfinite(series.seen), error, 0.0)
    return error / np.sqrt(np.einsum("nii->ni", series.noise))


def _cost(series: Series, observed: Float, start: Float) -> float:
    prior = (start - series.mean) / np.sqrt(np.diag(series.cov))
    return float(np.sum(_errors(series, observed) ** 2) + np.sum(prior**2))


def _step(series: Series, observed: Float, start: Float, count: int, damping: float) -> Float:
    n = len(series.times)
    sigma = np.sqrt(np.einsum("nii->ni", series.noise))
    known = np.isfinite(series.seen)
    slope = [(observed[:n, :, i + 1] - observed[:n, :, 0]) / STEPS[min(i, 5)] for i in range(count)]
    J = np.stack([np.where(known, s / sigma, 0.0).ravel() for s in slope], axis=1)
    weight = 1.0 / np.diag(series.cov)[:count]
    H = J.T @ J + np.diag(weight)
    g = J.T @ _errors(series, observed[:, :, 0]).ravel()
    g -= weight * (start - series.mean)[:count]
    step = np.zeros(len(start))
    if np.all(np.isfinite(H)):
        step[:count] = np.linalg.solve(H + damping * np.diag(np.diag(H)), g)
    return step


def _rmse(series: Series, observed: Float) -> float:
    error = series.seen[:, :2] - observed[: len(series.times), :2]
    square = np.sum(error**2, axis=1)
    return (
        float(np.sqrt(np.mean(square[np.isfinite(square)])))
        if np.isfinite(square).any()
        else np.nan
    )
