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
from dataclasses import dataclass

import numpy as np

from ..data import Float
from ..integrate import LANES, Kernel
from ..integrate.batch import propagate
from .joint import CONVERGED, STALLED, Fit, damped_step
from .normal import Normal, slots_by_name, trial_values
from .series import Free, Series
from .shooting import first_part

START_STEP = 1e-4
SHARES, ROUGH = (0.25, 0.5, 1.0), 5
"""First a quarter of each trial is fitted, then half, at most so many rounds, then all of it: a
model that would run away from a rough start is led to a fine one."""
TRIALS = 64
"""Trials simulated in one call: more would not stay in the processor's cache."""


@dataclass(frozen=True)
class PathFit:
    """A joint fit on trajectories, and the starts (trials, states) that go with it."""

    fit: Fit
    starts: Float


@dataclass(frozen=True)
class _Problem:
    """Everything that stays, padded to the longest trial: t trials, n frames, o observations."""

    kernel: Kernel
    base: Float
    free: tuple[Free, ...]
    groups: tuple[str, ...]
    open_states: int
    times: Float
    inputs: Float
    frames: np.ndarray
    constants: Float
    seen: Float
    weight: Float
    prior: Float
    prior_std: Float


@dataclass(frozen=True)
class _Arrow:
    """Blocks of the normal equations by trial: common (p, p), (p,), mixed (p, s), start (s, s)."""

    common: Float
    mixed: Float
    start: Float
    common_side: Float
    start_side: Float
    cost: Float


def fit_paths(
    kernel: Kernel,
    series: Sequence[Series],
    base: Float,
    free: Sequence[Free],
    *,
    start: Mapping[str, float] | None = None,
    open_states: int = 6,
    iterations: int = 40,
    tolerance: float = 1e-3,
    shares: Sequence[float] = SHARES,
) -> PathFit:
    """Levenberg-Marquardt on trajectories, starting states free, bounds kept.

    shares: of each trial's frames, one after the other, the last one 1; (1.0,) where the start is
    good or the starting states are known (`open_states` 0).

    Raises: ValueError where a trial has more numbers than lanes.
    """
    slots = slots_by_name(kernel)
    bounds = [kernel.system.parameters[slots[f.name]] for f in free]
    limits = np.array([[p.lower for p in bounds], [p.upper for p in bounds]])
    x = np.array([(start or {}).get(f.label, base[slots[f.name]]) for f in free])
    starts = np.array([s.mean for s in series])
    for share in shares:
        part = [first_part(s, share) for s in series]
        problem = _problem(kernel, part, base, free, open_states)
        whole = share == shares[-1]
        at = _minimised(problem, x, starts, limits, iterations=iterations if whole else ROUGH,
                        tolerance=tolerance if whole else 1.0)  # fmt: skip
        x, starts = at.x, at.starts
    return PathFit(Fit(tuple(free), x, _reduced(at.arrow, 0.0)[0], at.outcome, at.count), starts)


@dataclass(frozen=True)
class _Point:
    """Where a minimisation ended."""

    x: Float
    starts: Float
    arrow: _Arrow
    outcome: str
    count: int


def _minimised(
    problem: _Problem,
    x: Float,
    starts: Float,
    limits: Float,
    *,
    iterations: int,
    tolerance: float,
) -> _Point:
    lower, upper = limits
    arrow, damping, outcome, count = _arrow(problem, x, starts), 1e-3, STALLED, 0
    while np.isfinite(arrow.cost).all() and count < iterations and damping < 1e8:
        count += 1
        normal, to_start = _reduced(arrow, damping)
        step = np.clip(x + damped_step(normal, damping, x, lower, upper), lower, upper) - x
        moved = starts.copy()
        moved[:, : problem.open_states] += np.einsum("tsp,p->ts", to_start[0], step) + to_start[1]
        candidate = _arrow(problem, x + step, moved)
        small = step @ normal.hessian.sum(axis=0) @ step < tolerance**2 * len(x)
        if np.isfinite(candidate.cost).all() and candidate.cost.sum() <= arrow.cost.sum():
            x, starts, arrow, damping = x + step, moved, candidate, max(damping * 0.1, 1e-9)
        else:
            damping *= 10.0
        if small:
            outcome = CONVERGED
            break
    return _Point(x, starts, arrow, outcome, count)


def _problem(
    kernel: Kernel, series: Sequence[Series], base: Float, free: Sequence[Free], open_states: int
) -> _Problem:
    if open_states + len(free) > LANES - 1:
        raise ValueError(f"{open_states + len(free)} numbers a trial, at most {LANES - 1}")
    longest = max(len(s.times) for s in series)
    weights = [np.isfinite(s.seen) / np.sqrt(np.einsum("nii->ni", s.noise)) for s in series]

    def padded(rows: Sequence[Float], *, last: bool) -> Float:
        out = np.zeros((len(rows), longest, *rows[0].shape[1:]))
        for target, row in zip(out, rows, strict=True):
            target[: len(row)] = row
            target[len(row) :] = row[-1] if last else 0.0
        return out

    return _Problem(
        kernel, base, tuple(free), tuple(s.group for s in series), open_states,
        times=padded([s.times for s in series], last=True),
        inputs=padded([s.inputs for s in series], last=True),
        frames=np.array([len(s.times) for s in series]),
        constants=np.array([s.constants for s in series]),
        seen=padded([np.nan_to_num(s.seen) for s in series], last=False),
        weight=padded(weights, last=False),
        prior=np.array([s.mean for s in series]),
        prior_std=np.array([np.sqrt(np.diag(s.cov)) for s in series]),
    )  # fmt: skip


def _arrow(problem: _Problem, x: Float, starts: Float) -> _Arrow:
    """Blocks at a point, by batches of simulations."""
    slot, parameters = slots_by_name(problem.kernel), problem.kernel.system.parameters
    steps = np.array([
        1e-4 * max(abs(v), 0.05 * abs(parameters[slot[f.name]].start), 1e-6)
        for f, v in zip(problem.free, x, strict=True)
    ])  # fmt: skip
    with np.errstate(all="ignore"):  # a run that goes away has no finite cost and is not taken
        parts = [
            _part(problem, slice(first, first + TRIALS), x, steps, starts=starts)
            for first in range(0, len(starts), TRIALS)
        ]
    H, g, cost = (np.concatenate(column) for column in zip(*parts, strict=True))
    n = problem.open_states
    pull = (starts - problem.prior) / problem.prior_std
    H[:, range(n), range(n)] += 1.0 / problem.prior_std[:, :n] ** 2
    g[:, :n] -= (pull / problem.prior_std)[:, :n]
    return _Arrow(H[:, n:, n:], H[:, n:, :n], H[:, :n, :n], g[:, n:], g[:, :n],
                  cost + np.sum(pull**2, axis=1))  # fmt: skip


def _part(
    problem: _Problem, trials: slice, x: Float, steps: Float, *, starts: Float
) -> tuple[Float, Float, Float]:
    """J'J (t, s + p, s + p), J'e (t, s + p) and e'e (t,) of some trials: one call."""
    count, slots = problem.open_states, slots_by_name(problem.kernel)
    groups = problem.groups[trials]
    points = [trial_values(problem.kernel, problem.base, problem.free, x, g) for g in groups]
    values = np.repeat(np.array(points)[:, :, None], LANES, axis=2)
    for k, f in enumerate(problem.free):
        own = [f.group in (None, g) for g in groups]
        values[own, slots[f.name], count + 1 + k] += steps[k]
    state = np.repeat(starts[trials, :, None], LANES, axis=2)
    state[:, range(count), range(1, count + 1)] += START_STEP
    observed, _ = propagate(
        problem.kernel, state, values,
        np.repeat(problem.constants[trials, :, None], LANES, axis=2), times=problem.times[trials],
        inputs=problem.inputs[trials], frames=problem.frames[trials],
    )  # fmt: skip
    t = len(groups)
    error = ((problem.seen[trials] - observed[..., 0]) * problem.weight[trials]).reshape(t, -1)
    # differences to the first lane in place: lanes that differ in nothing become 0
    observed -= observed[..., :1].copy()
    observed *= problem.weight[trials][..., None]
    J = observed.reshape(t, -1, LANES)
    used = slice(1, 1 + count + len(x))
    size = np.concatenate([np.full(count, START_STEP), steps])
    H = (J.transpose(0, 2, 1) @ J)[:, used, used] / np.outer(size, size)
    g = (error[:, None, :] @ J)[:, 0, used] / size
    return H, g, np.sum(error**2, axis=1)


def _reduced(arrow: _Arrow, damping: float) -> tuple[Normal, tuple[Float, Float]]:
    """Normal equations without the starts; the starts' steps: slope (t, s, p) and own (t, s)."""
    C = arrow.start * (1.0 + damping * np.eye(arrow.start.shape[1]))
    inverse_mixed = _solved(C, arrow.mixed.transpose(0, 2, 1))
    own = _solved(C, arrow.start_side[:, :, None])[:, :, 0]
    hessian = arrow.common - arrow.mixed @ inverse_mixed
    gradient = arrow.common_side - np.einsum("tps,ts->tp", arrow.mixed, own)
    return Normal(hessian, gradient, -0.5 * arrow.cost), (-inverse_mixed, own)


def _solved(matrices: Float, sides: Float) -> Float:
    return np.asarray(np.linalg.solve(matrices, sides), dtype=np.float64)
