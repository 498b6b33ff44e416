"""Joint fit on whole free-running trajectories, each trial from a start of its own.

    minimise  sum over trials of |(seen - simulated(a, s_t)) / sigma|^2 + |s_t - prior|^2

over the common numbers a and the starting states s_t. The normal equations have the form of an
arrow: each trial's start couples only to a. Eliminating it leaves, for each trial,

    H = A - B C^-1 B',   g = a - B C^-1 c,

and the sum over trials is solved. Sixteen lanes hold a trial and all of its differences.
Right where nothing random pushes; the model being unstable in straight runs, small disturbances
look like physics here (prediction errors, `joint.fit`, do not fall for it).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..integrate import LANES, Kernel
from ..integrate.batch import propagate, run_in_threads
from .gram import set_products
from .joint import CONVERGED, STALLED, Fit, damped_step
from .normal import Normal, slots_by_name
from .padded import PaddedTrials, padded_trials
from .series import Free, Series

START_STEP = 1e-4
SHARES, COARSE_ITERATIONS = (0.25, 0.5, 1.0), 6
"""First a quarter of each trial is fitted, then half, at most so many rounds, in longer steps of
the integrator, then all of it: a model that would run away from a rough start is led to a fine
one."""
TRIALS_PER_CALL = 64
"""Trials simulated in one call: more would not stay in the processor's cache."""


@dataclass(frozen=True)
class PathFit:
    """A joint fit on trajectories, and the starts (trials, states) that go with it."""

    fit: Fit
    starts: Float


@dataclass(frozen=True)
class _Arrow:
    """Blocks of the normal equations by trial: common (p, p), (p,), mixed (p, s), start (s, s)."""

    common: Float
    mixed: Float
    start: Float
    common_side: Float
    start_side: Float
    cost: Float


NO_ARROW = _Arrow(*(np.zeros(0) for _ in range(6)))


def fit_paths(
    kernel: Kernel, series: Sequence[Series], base: Float, free: Sequence[Free], *, start:
    Mapping[str, float] | None = None, open_states: int = 6, iterations: int = 40, tolerance: float
    = 1e-3, shares: Sequence[float] = SHARES,
) -> PathFit:  # fmt: skip
    """Levenberg-Marquardt on trajectories, starting states free, bounds kept.

    shares: of each trial's frames, one after the other, the last one 1; (1.0,) where the start is
    good or the starting states are known (`open_states` 0).

    Raises: ValueError where a trial has more numbers than lanes.
    """
    slots = slots_by_name(kernel)
    bounds = [kernel.system.parameters[slots[f.name]] for f in free]
    limits = np.array([[p.lower for p in bounds], [p.upper for p in bounds]])
    x = np.array([(start or {}).get(f.label, base[slots[f.name]]) for f in free])
    at = _Point(np.clip(x, *limits), np.array([s.mean for s in series]), 1e-3)
    problem = padded_trials(kernel, series, base, free, open_states)
    for share in shares:
        whole = share == shares[-1]
        at = _minimised(problem.first_part(share), at, limits,
                        iterations=iterations if whole else COARSE_ITERATIONS,
                        tolerance=tolerance if whole else 1.0)  # fmt: skip
    normal, _ = _reduced(at.arrow, 0.0)
    return PathFit(Fit(tuple(free), at.x, normal, at.outcome, at.count), at.starts)


@dataclass(frozen=True)
class _Point:
    """Where a minimisation is, and what it found there."""

    x: Float
    starts: Float
    damping: float
    arrow: _Arrow = NO_ARROW
    outcome: str = STALLED
    count: int = 0


def _minimised(
    problem: PaddedTrials, at: _Point, limits: Float, *, iterations: int, tolerance: float
) -> _Point:
    """Rounds from a point on, until the next step would move nothing beyond the tolerance."""
    at = replace(at, arrow=_arrow(problem, at.x, at.starts), outcome=STALLED, count=0)
    while np.isfinite(at.arrow.cost).all() and at.count < iterations and at.damping < 1e8:
        normal, to_start = _reduced(at.arrow, at.damping)
        step = damped_step(normal, at.damping, at.x, *limits)
        x = np.clip(at.x + step, *limits)
        starts = at.starts.copy()
        shift = to_start[0] @ (x - at.x) + to_start[1]
        starts[:, : problem.open_states] += shift
        if _is_small(at.arrow, x - at.x, shift, tolerance):
            return replace(at, outcome=CONVERGED)
        arrow = _arrow(problem, x, starts)
        if np.isfinite(arrow.cost).all() and arrow.cost.sum() <= at.arrow.cost.sum():
            at = _Point(x, starts, max(at.damping * 0.1, 1e-9), arrow, count=at.count + 1)
        else:
            at = replace(at, damping=at.damping * 10.0, count=at.count + 1)
    return at


def _is_small(arrow: _Arrow, change: Float, shift: Float, tolerance: float) -> bool:
    """Whether a step moves nothing by more than `tolerance` of its deviation, starts included."""
    moved = change @ arrow.common.sum(axis=0) @ change
    moved += 2.0 * np.einsum("p,tps,ts->", change, arrow.mixed, shift)
    moved += np.einsum("ts,tsr,tr->", shift, arrow.start, shift)
    return bool(moved < tolerance**2 * max(change.size + shift.size, 1))


def _arrow(problem: PaddedTrials, x: Float, starts: Float) -> _Arrow:
    """Blocks at a point, by batches of simulations."""
    n = problem.open_states
    size = np.concatenate([np.full(n, START_STEP),
                           1e-4 * np.maximum(np.abs(x), problem.least_step)])  # fmt: skip
    with np.errstate(all="ignore"):  # a run that goes away has no finite cost and is not taken
        parts = [
            _products(problem, slice(first, first + TRIALS_PER_CALL), x, size, starts=starts)
            for first in range(0, len(starts), TRIALS_PER_CALL)
        ]
    products = np.concatenate(parts)
    H, g = products[:, 1:, 1:] / np.outer(size, size), products[:, 0, 1:] / size
    pull = (starts - problem.prior) / problem.prior_std
    H[:, range(n), range(n)] += 1.0 / problem.prior_std[:, :n] ** 2
    g[:, :n] -= (pull / problem.prior_std)[:, :n]
    return _Arrow(H[:, n:, n:], H[:, n:, :n], H[:, :n, :n], g[:, n:], g[:, :n],
                  products[:, 0, 0] + np.sum(pull**2, axis=1))  # fmt: skip


def _products(
    problem: PaddedTrials, trials: slice, x: Float, size: Float, *, starts: Float
) -> Float:
    """Products (t, 1 + s, 1 + s) of errors and of differences `size` of some trials: one call."""
    count = problem.open_states
    state = np.repeat(starts[trials, :, None], LANES, axis=2)
    state[:, range(count), range(1, count + 1)] += START_STEP
    values = np.empty((len(state), len(problem.base), LANES))
    values[:] = problem.base[:, None]
    for k, (slot, own) in enumerate(problem.own):
        values[own[trials], slot] = x[k]
        values[own[trials], slot, count + 1 + k] += size[count + k]
    observed, _ = propagate(
        problem.kernel, state, values, problem.constants[trials], times=problem.times[trials],
        inputs=problem.inputs[trials], frames=problem.frames[trials],
        step_s=problem.kernel.system.step_s or problem.step_s,
    )  # fmt: skip
    seen, weight = (np.ascontiguousarray(a[trials]) for a in (problem.seen, problem.weight))
    out = np.empty((len(state), 1 + len(size), 1 + len(size)))
    run_in_threads(lambda *ends: set_products(observed, seen, weight, ends, out), len(state))
    return out


def _reduced(arrow: _Arrow, damping: float) -> tuple[Normal, tuple[Float, Float]]:
    """Normal equations without the starts; the starts' steps: slope (t, s, p) and own (t, s)."""
    if arrow.start.size == 0:
        nothing = arrow.mixed.transpose(0, 2, 1)
        return Normal(arrow.common, arrow.common_side, -0.5 * arrow.cost), (
            nothing,
            arrow.start_side,
        )
    C = arrow.start * (1.0 + damping * np.eye(arrow.start.shape[1]))
    inverse_mixed = _solved(C, arrow.mixed.transpose(0, 2, 1))
    own = _solved(C, arrow.start_side[:, :, None])[:, :, 0]
    hessian = arrow.common - arrow.mixed @ inverse_mixed
    gradient = arrow.common_side - np.einsum("tps,ts->tp", arrow.mixed, own)
    return Normal(hessian, gradient, -0.5 * arrow.cost), (-inverse_mixed, own)


def _solved(matrices: Float, sides: Float) -> Float:
    return np.asarray(np.linalg.solve(matrices, sides), dtype=np.float64)
