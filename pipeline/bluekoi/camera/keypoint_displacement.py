"""Keypoints that are displaced from their place on the robot by a constant vector in the pool.

A detector that takes a highlight or a shadow for a part of the robot displaces it towards one side
of the pool, whatever the heading of the robot. Let d_f and d_b be the displacements of the front
and the back end of a rigid length, and u the unit vector from back to front. The measured length
has the excess

    y = u' (d_f - d_b) + Z b + e    (Z b: `length_regression`).

This excess changes its sign when the robot turns by 180 degrees. That of a camera error does not: a
lens stretches a length equally in both directions.

A displacement common to all keypoints does not change lengths. The vectors d are therefore given
relative to the largest group of keypoints that are not displaced relative to each other. Of two
groups of the same size it is not known which one is displaced; the corrected motion is the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.special import chdtri

from ..data import Float, Positions
from ..study import Robot
from .length_regression import (
    DISPLACEMENT_STD_SHARE,
    by_keypoint,
    directions_of_lengths,
    length_misfit,
    length_of_rigid_parts_m,
    regress_lengths,
)
from .length_windows import window_means
from .rigid_distances import RigidDistances, rigid_distances

MIN_SIGMAS = 5.0
"""Standard errors from 0 beyond which a keypoint counts as displaced. Fifteen studies
of `campus_pool` 5841, `tidal_lock` 9402 and `leading_plate` 5701, in which no keypoint is displaced
in this way, reach 2.5 (60 keypoints, relative to the mean of the others)."""
FALSE_ALARM_PROBABILITY = 6e-7
"""Probability with which a change within the session is found by chance: that of `MIN_SIGMAS`
standard deviations of a normal distribution."""
MIN_DISPLACEMENT_SHARE = 0.006
"""Smallest displacement that is corrected, over the length of the rigid parts from nose to tail:
2 mm for the published robot, whose keypoints are labelled to 1 mm in careful work."""
MAX_ESTIMATES, MAX_CHANGES_TRIED = 6, 40
DECIMALS = 4
"""Displacements are used to a tenth of a millimetre: their last digits change with every trial that
is added, and each change places the keypoints of all trials again."""
ROUNDING_VARIANCE_M2 = 0.1 ** (2 * DECIMALS) / 12.0


@dataclass(frozen=True)
class KeypointDisplacement:
    """Displacement (x, y) of a keypoint in the pool frame, with its standard errors, m, which
    include the rounding.

    sigmas: distance from 0 in standard errors.
    """

    x_m: float
    y_m: float
    x_std_m: float
    y_std_m: float
    sigmas: float


def displacements_by_part(
    trials: Sequence[Positions], head_lengths_m: Sequence[float], robot: Robot
) -> list[tuple[range, dict[str, KeypointDisplacement]]]:
    """Displaced keypoints of each part of the session (places in `trials`, in the order of filming)
    in which there are any. There is one part, or two where a displacement begins, ends or changes,
    as when a lamp is moved.

    Raises: InputError where no rigid pair is ever seen.
    """
    common = keypoint_displacements(trials, head_lengths_m, robot)
    corrected = [without_displacements(one, vectors_m(common)) for one in trials]
    parts = _parts_of_session(corrected, head_lengths_m, robot)
    if len(parts) == 1:
        return [(parts[0], common)] if common else []
    each = [
        keypoint_displacements([trials[k] for k in part], [head_lengths_m[k] for k in part], robot)
        for part in parts
    ]
    first, second = map(vectors_m, each)
    if common and _agree(first, second, MIN_DISPLACEMENT_SHARE * robot.body_length_m):
        return [(range(len(trials)), common)]
    displaced = [(part, found) for part, found in zip(parts, each, strict=True) if found]
    return displaced or ([(range(len(trials)), common)] if common else [])


def _agree(
    one: Mapping[str, tuple[float, float]], other: Mapping[str, tuple[float, float]], least_m: float
) -> bool:
    """Whether the same keypoints are displaced, by vectors that differ by less than `least_m`."""
    return one.keys() == other.keys() and all(
        np.hypot(*np.subtract(one[name], other[name])) < least_m for name in one
    )


def _parts_of_session(
    trials: Sequence[Positions], head_lengths_m: Sequence[float], robot: Robot
) -> list[range]:
    """Parts with one displacement each. The best of up to `MAX_CHANGES_TRIED` places of a change
    counts if the misfit becomes smaller by more than chi-squared does by chance with
    `FALSE_ALARM_PROBABILITY` at any of these places, with as many degrees of freedom as a second
    part adds.

    Raises: InputError where no rigid pair is ever seen.
    """
    whole, count = range(len(trials)), len(trials)
    windows = window_means(rigid_distances(trials, head_lengths_m, robot))
    names, columns, stds = displacement_columns(windows)
    places = np.linspace(2, count - 2, min(max(count - 3, 0), MAX_CHANGES_TRIED))
    if len(names) < 3 or not len(places):
        return [whole]

    def in_two_parts(first: int) -> Float:
        before = (windows.trial < first)[:, None]
        return np.column_stack([columns * before, columns * ~before])

    _, _, variance = regress_lengths(windows, columns, stds)
    twice = np.concatenate([stds, stds])
    tried = {int(first): length_misfit(windows, in_two_parts(int(first)), twice, variance)
             for first in places.round()}  # fmt: skip
    change = min(tried, key=lambda first: tried[first])
    _, _, variance = regress_lengths(windows, in_two_parts(change), twice)
    gain = length_misfit(windows, columns, stds, variance) - length_misfit(
        windows, in_two_parts(change), twice, variance
    )
    if gain < chdtri(columns.shape[1], FALSE_ALARM_PROBABILITY / len(tried)):
        return [whole]
    return [range(change), range(change, count)]


def keypoint_displacements(
    trials: Sequence[Positions], head_lengths_m: Sequence[float], robot: Robot
) -> dict[str, KeypointDisplacement]:
    """The displaced keypoints by name; none where fewer than three keypoints are connected by
    lengths.

    The estimate is repeated with corrected positions, since the directions and head angles of the
    first one are those of displaced keypoints.

    Raises: InputError where no rigid pair is ever seen.
    """
    vectors: dict[str, tuple[float, float]] = {}
    found: dict[str, KeypointDisplacement] = {}
    for _ in range(MAX_ESTIMATES):
        corrected = [without_displacements(one, vectors) for one in trials]
        windows = window_means(rigid_distances(corrected, head_lengths_m, robot))
        found = _displaced(windows, vectors)
        if vectors_m(found) == vectors:
            break
        vectors = vectors_m(found)
    return found


def vectors_m(displaced: Mapping[str, KeypointDisplacement]) -> dict[str, tuple[float, float]]:
    """Keypoint -> displacement (x, y), m."""
    return {name: (found.x_m, found.y_m) for name, found in displaced.items()}


def without_displacements(
    positions: Positions, displacements: Mapping[str, tuple[float, float]]
) -> Positions:
    """Positions without the displacements (x, y), m, of their keypoints."""
    if not displacements:
        return positions
    vectors = np.array([displacements.get(name, (0.0, 0.0)) for name in positions.names])
    return replace(positions, xy_m=positions.xy_m - vectors)


def _displaced(
    windows: RigidDistances, corrected: Mapping[str, tuple[float, float]]
) -> dict[str, KeypointDisplacement]:
    """The keypoints that are displaced relative to most others, by what was corrected and what the
    lengths show in addition.
    """
    names, columns, stds = displacement_columns(windows)
    if len(names) < 3:
        return {}
    least_m = MIN_DISPLACEMENT_SHARE * length_of_rigid_parts_m(windows)
    estimate, cov, _ = regress_lengths(windows, columns, stds)
    vectors = estimate.reshape(-1, 2) + [corrected.get(name, (0.0, 0.0)) for name in names]
    reference = _undisplaced(vectors, cov)
    found = {}
    for k, name in enumerate(names):
        if k in reference:
            continue
        vector, own = _relative_to(vectors, cov, k, reference)
        sigmas = _sigmas(vector, own)
        if sigmas <= MIN_SIGMAS or np.hypot(*vector) <= least_m:
            continue
        x, y = np.round(vector, DECIMALS)
        x_std, y_std = np.sqrt(np.diag(own) + ROUNDING_VARIANCE_M2)
        found[name] = KeypointDisplacement(float(x), float(y), float(x_std), float(y_std), sigmas)
    return found


def _undisplaced(vectors: Float, cov: Float) -> tuple[int, ...]:
    """The largest group of keypoints whose vectors agree; of several of this size, that whose
    vectors agree best. Two keypoints are the least.
    """
    keypoints = range(len(vectors))
    for size in range(len(vectors), 2, -1):
        misfits = {group: _difference_misfit(vectors, cov, group)
                   for group in combinations(keypoints, size)}  # fmt: skip
        best = min(misfits, key=lambda group: misfits[group])
        if misfits[best] < chdtri(2 * (size - 1), FALSE_ALARM_PROBABILITY):
            return best
    pairs = list(combinations(keypoints, 2))
    return min(pairs, key=lambda group: _difference_misfit(vectors, cov, group))


def _difference_misfit(vectors: Float, cov: Float, group: Sequence[int]) -> float:
    """Chi-squared of the differences of vectors within a group."""
    count = len(vectors)
    weights = np.eye(count)[list(group[1:])] - np.eye(count)[group[0]]
    T = np.kron(weights, np.eye(2))
    differences = (weights @ vectors).ravel()
    return float(differences @ np.linalg.solve(T @ cov @ T.T, differences))


def _relative_to(
    vectors: Float, cov: Float, k: int, reference: Sequence[int]
) -> tuple[Float, Float]:
    """Displacement (2,) of keypoint k relative to the mean of others, and its covariance (2, 2)."""
    weights = np.zeros(len(vectors))
    weights[list(reference)] = -1.0 / len(reference)
    weights[k] += 1.0
    T = np.kron(weights, np.eye(2))
    return np.asarray(weights @ vectors), np.asarray(T @ cov @ T.T)


def _sigmas(vector: Float, cov: Float) -> float:
    return float(np.sqrt(vector @ np.linalg.solve(cov, vector)))


def displacement_columns(windows: RigidDistances) -> tuple[tuple[str, ...], Float, Float]:
    """Keypoints (k,) that were seen; excess (n, 2 k) of each length by a displacement of each of
    them by 1 m along x and along y; and prior standard deviations (2 k,) of the displacements, m.
    """
    directions = directions_of_lengths(windows)
    patterns = {name: p for name, p in by_keypoint(windows, directions, directions).items()
                if p.any()}  # fmt: skip
    columns = np.column_stack(list(patterns.values()))
    std_m = DISPLACEMENT_STD_SHARE * length_of_rigid_parts_m(windows)
    return tuple(patterns), columns, np.full(columns.shape[1], std_m)
