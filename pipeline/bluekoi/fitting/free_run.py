"""Free-running simulations from the starting state that suits each trial best."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import LANES, CompiledSystem
from ..integrate.batch import map_ranges_in_threads, simulate_batch
from .gram import compute_column_products
from .series import TrialSeries, observations_and_weights, padded_arrays

FIT_HORIZON_SHARES = (0.25, 0.5, 1.0)
"""First a quarter of each trial is fitted, then half, then all of it: a model that would run away
from a rough start is led to a fine one."""
START_STATE_DIFFERENCE_STEP = 1e-4
"""Size of the differences in the starting states, in their SI units."""


@dataclass(frozen=True)
class FreeRun:
    """Free run of one trial: start (states,), states (n, states), observed (n, observations).

    rmse: root mean square of the distance between seen and simulated over the first two
    observations (a path, m, where they are x and y).
    """

    start: Float
    states: Float
    observed: Float
    rmse: float


def free_runs(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    values: Sequence[Float],
    *,
    open_states: int = 6,
    iterations: int = 8,
) -> list[FreeRun]:
    """A `FreeRun` a trial; the first `open_states` of the start are fitted (damped Gauss-Newton).

    The start's prior is that of the series; all trials advance together. First a quarter of each
    trial is fitted, then half, then all of it: an unstable model that would run away from a rough
    start is led to a fine one.
    """
    starts = np.array([s.mean for s in series])
    for share in FIT_HORIZON_SHARES:
        part = [first_share_of_trial(s, share) for s in series]
        starts = _fitted_starts(_padded_runs(kernel, part, values, open_states), starts,
                                iterations=iterations)  # fmt: skip
    observed, states = _padded_runs(kernel, series, values, 0).simulate_from(
        starts, keep_states=True
    )
    return [
        FreeRun(
            x, run[: len(s.times), :, 0], o[: len(s.times), :, 0], _position_rmse(s, o[:, :, 0])
        )
        for s, x, run, o in zip(series, starts, states, observed, strict=True)
    ]


def first_share_of_trial(series: TrialSeries, share: float) -> TrialSeries:
    """The first share of a trial's frames, two at least."""
    n = max(2, int(np.ceil(share * len(series.times))))
    return series.slice_frames(0, n)


@dataclass(frozen=True)
class _PaddedRuns:
    """Trials t side by side, n frames, o observations: seen (t, n, o) and weight, one over the
    stated deviation, 0 where missing; prior mean and deviation (t, states) of the starts, of which
    the first `count` are open.
    """

    kernel: CompiledSystem
    values: Float
    constants: Float
    times: Float
    inputs: Float
    frames: np.ndarray
    seen: Float
    weight: Float
    mean: Float
    std: Float
    count: int

    def simulate_from(self, starts: Float, *, keep_states: bool = False) -> tuple[Float, Float]:
        """Observations and states of runs from these starts and, in further lanes, beside them."""
        state = np.repeat(starts[:, :, None], LANES, axis=2)
        state[:, range(self.count), range(1, self.count + 1)] += START_STATE_DIFFERENCE_STEP
        return simulate_batch(
            self.kernel, state, self.values, self.constants, times=self.times, inputs=self.inputs,
            frames=self.frames, keep_states=keep_states,
        )  # fmt: skip

    @np.errstate(over="ignore", invalid="ignore")  # a run that goes away has no finite cost
    def gram_matrices(self, starts: Float) -> Float:
        """Products (t, 1 + count, 1 + count) of the errors, those of the prior included, and of
        their slopes; infinite cost where a run goes away.
        """
        observed, _ = self.simulate_from(starts)
        out = np.empty((len(starts), 1 + self.count, 1 + self.count))
        map_ranges_in_threads(
            lambda *ends: compute_column_products(observed, self.seen, self.weight, ends, out),
            len(out),
        )
        out[:, 1:] /= START_STATE_DIFFERENCE_STEP
        out[:, :, 1:] /= START_STATE_DIFFERENCE_STEP
        error = (self.mean - starts) / self.std
        own = range(1, self.count + 1)
        out[:, 0, 0] += np.sum(error**2, axis=1)
        out[:, own, own] += self.std[:, : self.count] ** -2.0
        out[:, own, 0] += (error / self.std)[:, : self.count]
        out[~np.isfinite(out).all(axis=(1, 2)), 0, 0] = np.inf
        return out


def _padded_runs(
    kernel: CompiledSystem, series: Sequence[TrialSeries], values: Sequence[Float], count: int
) -> _PaddedRuns:
    frames, seen, weight = observations_and_weights(series)
    lanes = [np.repeat(np.array(rows)[:, :, None], LANES, axis=2)
             for rows in (values, [s.constants for s in series])]  # fmt: skip
    return _PaddedRuns(
        kernel, lanes[0], lanes[1],
        times=padded_arrays([s.times for s in series]),
        inputs=padded_arrays([s.inputs for s in series]),
        frames=frames,
        seen=seen,
        weight=weight,
        mean=np.array([s.mean for s in series]),
        std=np.sqrt([np.diag(s.cov) for s in series]),
        count=count,
    )  # fmt: skip


def _fitted_starts(runs: _PaddedRuns, starts: Float, *, iterations: int) -> Float:
    """Starts (trials, states) from which each trial's run is closest to what was seen."""
    starts, products = starts.copy(), runs.gram_matrices(starts)
    damping = np.full(len(starts), 1e-3)
    for _ in range(iterations):
        trial = starts + _damped_steps(products, damping, starts.shape[1])
        found = runs.gram_matrices(trial)
        cost, new = products[:, 0, 0], found[:, 0, 0]
        with np.errstate(invalid="ignore"):  # both infinite: not settled
            settled = np.abs(cost - new) <= 1e-6 * cost
        better = new <= cost
        damping = np.where(better, damping * 0.2, damping * 10.0)
        starts[better], products[better] = trial[better], found[better]
        if settled.all():
            break
    return starts


def _damped_steps(products: Float, damping: Float, states: int) -> Float:
    """Damped steps (trials, states) to smaller errors; none where a run goes away."""
    usable = np.isfinite(products).all(axis=(1, 2))
    H, g = products[usable, 1:, 1:], products[usable, 1:, 0]
    H = H * (1.0 + damping[usable, None, None] * np.eye(H.shape[1]))
    steps = np.zeros((len(products), states))
    steps[usable, : H.shape[1]] = np.linalg.solve(H, g[:, :, None])[:, :, 0]
    return steps


def _position_rmse(series: TrialSeries, observed: Float) -> float:
    error = series.seen[:, :2] - observed[: len(series.times), :2]
    with np.errstate(over="ignore", invalid="ignore"):  # a run that goes away
        square = np.sum(error**2, axis=1)
    return (
        float(np.sqrt(np.mean(square[np.isfinite(square)])))
        if np.isfinite(square).any()
        else np.nan
    )
