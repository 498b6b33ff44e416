"""Joint fit on whole free-running trajectories, each trial from a start of its own.

    minimise  sum over trials of |(seen - simulated(a, s_t)) / sigma|^2 + |s_t - prior|^2

over the common parameters a and the starting states s_t. The normal matrix is bordered
block-diagonal (an arrowhead): each trial's start couples only to a. Eliminating it leaves the Schur
complement of each trial,

    H = A - B C^-1 B',   g = b - B C^-1 c,

with the right-hand sides b of the parameters and c of the start; the sum over trials is solved.
Sixteen SIMD lanes hold a trial and all runs of its finite differences. The criterion is right where
no random forces act: the model is unstable in straight runs, and small disturbances then look like
physics. Prediction errors (`fit_parameters_jointly`) do not have this fault.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from ..integrate import LANES, CompiledSystem
from ..integrate.batch import map_ranges_in_threads, simulate_batch
from .bounded_step import bounded_step
from .free_run import FIT_HORIZON_SHARES, START_STATE_DIFFERENCE_STEP
from .gram import compute_column_products
from .joint_fit import CONVERGED, STALLED, ParameterFit, free_parameter_definitions
from .normal import NormalEquationsByTrial
from .padded import PaddedTrials, padded_trials
from .predictions import parameter_index_by_name
from .series import FreeParameter, TrialSeries

PREDICTION_ERRORS, TRAJECTORIES = "prediction errors", "trajectories"
"""The two criteria by which models are fitted."""
MAX_TRAJECTORY_PARAMETERS = LANES - 1
"""Starting states and parameters of a trial: each has a lane beside that of the simulation at the
point itself."""
COARSE_ITERATIONS = 6
"""Largest number of rounds of a fit to a part of each trial (`FIT_HORIZON_SHARES`), in longer steps
of the integrator."""
TRIALS_PER_SIMULATION_BATCH = 64
"""Trials simulated in one call: more would not stay in the processor's cache."""


@dataclass(frozen=True)
class TrajectoryFit:
    """A joint fit on trajectories, and the starts (trials, states) that go with it."""

    fit: ParameterFit
    starts: Float


@dataclass(frozen=True)
class _BlockNormalEquations:
    """Blocks of the normal equations by trial (t), of parameters (p) and starting states (s).

    common (t, p, p), mixed (t, p, s), start (t, s, s); right-hand sides common_rhs (t, p) and
    start_rhs (t, s); cost (t,): sum of squares.
    """

    common: Float
    mixed: Float
    start: Float
    common_rhs: Float
    start_rhs: Float
    cost: Float

    @property
    def finite(self) -> bool:
        """Whether no simulation of a trial or of a difference diverges."""
        parts = (self.common, self.mixed, self.start, self.common_rhs, self.start_rhs, self.cost)
        return all(bool(np.isfinite(part).all()) for part in parts)


NO_BLOCK_NORMAL_EQUATIONS = _BlockNormalEquations(*(np.zeros(0) for _ in range(6)))


def fit_trajectories(
    kernel: CompiledSystem,
    series: Sequence[TrialSeries],
    base: Float,
    free: Sequence[FreeParameter],
    *,
    start: Mapping[str, float] | None = None,
    open_states: int = 6,
    iterations: int = 40,
    tolerance: float = 1e-3,
    shares: Sequence[float] = FIT_HORIZON_SHARES,
) -> TrajectoryFit:
    """Levenberg-Marquardt on trajectories, starting states free, bounds kept.

    shares: of each trial's frames, one after the other, the last one 1; (1.0,) where the start is
    good or the starting states are known (`open_states` 0).

    Raises: ValueError where a trial has more numbers than lanes.
    """
    slots = parameter_index_by_name(kernel)
    bounds = [kernel.system.parameters[slots[f.name]] for f in free]
    limits = np.array([[p.lower for p in bounds], [p.upper for p in bounds]])
    x = np.array([(start or {}).get(f.label, base[slots[f.name]]) for f in free])
    at = _Iterate(np.clip(x, *limits), np.array([s.mean for s in series]), 1e-3)
    problem = padded_trials(kernel, series, base, free, open_states)
    for share in shares:
        whole = share == shares[-1]
        at = _minimise_from(problem.first_share_of_trials(share), at, limits,
                            iterations=iterations if whole else COARSE_ITERATIONS,
                            tolerance=tolerance if whole else 1.0)  # fmt: skip
    normal, _ = _eliminate_starting_states(at.blocks, 0.0)
    found = ParameterFit(tuple(free), at.x, normal, at.outcome, at.count,
                         free_parameter_definitions(kernel.system, free))  # fmt: skip
    return TrajectoryFit(found, at.starts)


@dataclass(frozen=True)
class _Iterate:
    """Where a minimisation is, and what it found there."""

    x: Float
    starts: Float
    damping: float
    blocks: _BlockNormalEquations = NO_BLOCK_NORMAL_EQUATIONS
    outcome: str = STALLED
    count: int = 0


def _minimise_from(
    problem: PaddedTrials, at: _Iterate, limits: Float, *, iterations: int, tolerance: float
) -> _Iterate:
    """Rounds from a point on, until the next step would move nothing beyond the tolerance."""
    at = replace(
        at, blocks=_block_normal_equations(problem, at.x, at.starts), outcome=STALLED, count=0
    )
    while at.blocks.finite and at.count < iterations and at.damping < 1e8:
        normal, to_start = _eliminate_starting_states(at.blocks, at.damping)
        H, g = normal.hessian.sum(axis=0), normal.gradient.sum(axis=0)
        damped = H + at.damping * np.diag(np.diag(H))
        x = np.clip(at.x + bounded_step(damped, g, *(limits - at.x)), *limits)
        starts = at.starts.copy()
        shift = to_start[0] @ (x - at.x) + to_start[1]
        starts[:, : problem.open_states] += shift
        if _is_small_step(at.blocks, x - at.x, shift, tolerance):
            return replace(at, outcome=CONVERGED)
        blocks = _block_normal_equations(problem, x, starts)
        if blocks.finite and blocks.cost.sum() <= at.blocks.cost.sum():
            at = _Iterate(x, starts, max(at.damping * 0.1, 1e-9), blocks, count=at.count + 1)
        else:
            at = replace(at, damping=at.damping * 10.0, count=at.count + 1)
    return at


def _is_small_step(
    blocks: _BlockNormalEquations, change: Float, shift: Float, tolerance: float
) -> bool:
    """Whether a step moves nothing by more than `tolerance` of its deviation, starts included."""
    moved = change @ blocks.common.sum(axis=0) @ change
    moved += 2.0 * np.einsum("p,tps,ts->", change, blocks.mixed, shift)
    moved += np.einsum("ts,tsr,tr->", shift, blocks.start, shift)
    return bool(moved < tolerance**2 * max(change.size + shift.size, 1))


def _block_normal_equations(
    problem: PaddedTrials, x: Float, starts: Float
) -> _BlockNormalEquations:
    """`_BlockNormalEquations` at a point, from batches of simulations."""
    n = problem.open_states
    size = np.concatenate([np.full(n, START_STATE_DIFFERENCE_STEP),
                           1e-4 * np.maximum(np.abs(x), problem.least_step)])  # fmt: skip
    with np.errstate(all="ignore"):  # a run that goes away has no finite cost and is not taken
        parts = [
            _residual_and_jacobian_products(
                problem, slice(first, first + TRIALS_PER_SIMULATION_BATCH), x, size, starts=starts
            )
            for first in range(0, len(starts), TRIALS_PER_SIMULATION_BATCH)
        ]
    products = np.concatenate(parts)
    H, g = products[:, 1:, 1:] / np.outer(size, size), products[:, 0, 1:] / size
    pull = (starts - problem.prior) / problem.prior_std
    H[:, range(n), range(n)] += 1.0 / problem.prior_std[:, :n] ** 2
    g[:, :n] -= (pull / problem.prior_std)[:, :n]
    return _BlockNormalEquations(H[:, n:, n:], H[:, n:, :n], H[:, :n, :n], g[:, n:], g[:, :n],
                  products[:, 0, 0] + np.sum(pull**2, axis=1))  # fmt: skip


def _residual_and_jacobian_products(
    problem: PaddedTrials, trials: slice, x: Float, size: Float, *, starts: Float
) -> Float:
    """Products (t, 1 + s, 1 + s) of errors and of differences `size` of some trials: one call."""
    count = problem.open_states
    state = np.repeat(starts[trials, :, None], LANES, axis=2)
    state[:, range(count), range(1, count + 1)] += START_STATE_DIFFERENCE_STEP
    values = np.empty((len(state), len(problem.base), LANES))
    values[:] = problem.base[:, None]
    for k, (slot, own) in enumerate(problem.own):
        values[own[trials], slot] = x[k]
        values[own[trials], slot, count + 1 + k] += size[count + k]
    observed, _ = simulate_batch(
        problem.kernel, state, values, problem.constants[trials], times=problem.times[trials],
        inputs=problem.inputs[trials], frames=problem.frames[trials],
        step_s=problem.kernel.system.longest_step_s(problem.step_s),
    )  # fmt: skip
    seen, weight = (np.ascontiguousarray(a[trials]) for a in (problem.seen, problem.weight))
    out = np.empty((len(state), 1 + len(size), 1 + len(size)))
    map_ranges_in_threads(
        lambda *ends: compute_column_products(observed, seen, weight, ends, out), len(state)
    )
    return out


def _eliminate_starting_states(
    blocks: _BlockNormalEquations, damping: float
) -> tuple[NormalEquationsByTrial, tuple[Float, Float]]:
    """Schur complement, summed over trials; the starts' steps: slope (t, s, p) and own (t, s)."""
    if blocks.start.size == 0:
        nothing = blocks.mixed.transpose(0, 2, 1)
        return NormalEquationsByTrial(blocks.common, blocks.common_rhs, -0.5 * blocks.cost), (
            nothing,
            blocks.start_rhs,
        )
    C = blocks.start * (1.0 + damping * np.eye(blocks.start.shape[1]))
    inverse_mixed = _solve_stacked(C, blocks.mixed.transpose(0, 2, 1))
    own = _solve_stacked(C, blocks.start_rhs[:, :, None])[:, :, 0]
    hessian = blocks.common - blocks.mixed @ inverse_mixed
    gradient = blocks.common_rhs - np.einsum("tps,ts->tp", blocks.mixed, own)
    return NormalEquationsByTrial(hessian, gradient, -0.5 * blocks.cost), (-inverse_mixed, own)


def _solve_stacked(matrices: Float, sides: Float) -> Float:
    return np.asarray(np.linalg.solve(matrices, sides), dtype=np.float64)
