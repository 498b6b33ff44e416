"""Uncertainty over gaps, calibrated on artificial gaps of the same length in the same trial.

A process noise estimated from consecutive frames may give a wrong error over many unseen frames,
because the motion of a fish changes from stroke to stroke. Therefore measured frames are hidden in
intervals as long as the gap. This changes the smoothed state by d, with the covariance

    cov(d) = P_hidden - P_seen,

so that d' d / tr cov(d), averaged over the artificial gaps, is the factor by which the model's
variance over such a gap is wrong.
Source: deletion diagnostics, de Jong and Penzer, J. Amer. Statist. Assoc. 93 (1998) 796.
"""

from __future__ import annotations

import numpy as np

from ..data import BoolNDArray
from .kalman_numba import compiled_filter_and_smooth
from .linear_gaussian import LinearGaussianModel, SmoothedStates

MIN_GAP_NODES = 3
"""Shortest gap, in nodes, whose standard deviations are calibrated."""
GAP_MARGIN_NODES, MIN_MEASURED_SHARE = 3, 0.8
"""Artificial gaps lie where this share of their nodes, and of so many nodes on both sides, was
measured."""
PRIOR_GAP_COUNT = 0.25
"""Weight of the model's own variance, as a number of artificial gaps with a factor of 1."""
WEIGHT_DECAY_IN_GAP_LENGTHS = 3.0
"""Weight of an artificial gap: exp(-distance from the gap / (this many gap lengths))."""


def with_calibrated_gap_covariance(
    model: LinearGaussianModel, used: BoolNDArray, state: SmoothedStates, coords: int
) -> SmoothedStates:
    """The smoothed states, their covariance over gaps scaled by what artificial gaps show.

    What a gap adds to the variance of its neighbours is scaled, so that no step arises at its ends.
    coords: how many leading states make the position, by which the factor is judged.
    """
    P = state.P.copy()
    for first, last in index_ranges_of_true(~used):
        if last - first < MIN_GAP_NODES or first == 0 or last == len(used):
            continue
        factor = _variance_factor(model, used, state, (first, last), coords)
        share = np.linspace(0, 1, last - first + 2)[1:-1, None]
        stated = np.einsum("nii->ni", state.P)
        edge = (1 - share) * stated[first - 1] + share * stated[last]
        inside = stated[first:last]
        wide = np.where(inside > edge, edge + factor * (inside - edge), inside)
        scale = np.sqrt(wide / np.maximum(inside, 1e-300))
        P[first:last] *= scale[:, :, None] * scale[:, None, :]
    return SmoothedStates(state.x, P)


def _variance_factor(
    model: LinearGaussianModel,
    used: BoolNDArray,
    state: SmoothedStates,
    gap: tuple[int, int],
    coords: int,
) -> float:
    """Factor of the variance over a gap: mean of d' d / tr cov(d) over artificial gaps.

    Times (1 + 2 / freedom), the variance of a Student t, as the factor itself is an estimate.
    """
    length, middle = gap[1] - gap[0], 0.5 * (gap[0] + gap[1])
    period, step = 2 * (length + GAP_MARGIN_NODES), max(length // 2, 1)
    total = weight = PRIOR_GAP_COUNT
    for offset in range(GAP_MARGIN_NODES, period + GAP_MARGIN_NODES, step):
        starts = [
            k
            for k in range(offset, len(used) - length - GAP_MARGIN_NODES, period)
            if used[k - GAP_MARGIN_NODES : k + length + GAP_MARGIN_NODES].mean()
            > MIN_MEASURED_SHARE
        ]
        hidden = used.copy()
        for k in starts:
            hidden[k : k + length] = False
        other = compiled_filter_and_smooth(model, hidden) if starts else state
        moved = ((other.x - state.x)[:, :coords] ** 2).sum(axis=1)
        stated = np.einsum("nii->n", (other.P - state.P)[:, :coords, :coords])
        for k in starts:
            at = slice(k, k + length)
            # artificial gaps overlap: together they count as gaps side by side
            count = (
                step
                / length
                * np.exp(-abs(k + 0.5 * length - middle) / (WEIGHT_DECAY_IN_GAP_LENGTHS * length))
            )
            total += count * moved[at].sum() / max(stated[at].sum(), 1e-300)
            weight += count
    return float(total / weight * (1 + 2 / (coords * weight)))


def index_ranges_of_true(mask: BoolNDArray) -> list[tuple[int, int]]:
    """First and one past the last index of each run in which `mask` (n,) holds."""
    ends = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return [(int(a), int(b)) for a, b in ends.reshape(-1, 2)]
