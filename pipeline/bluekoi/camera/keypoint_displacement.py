"""Keypoints that are displaced from their place on the robot, whatever the heading of the robot.

A detector that takes a highlight or a shadow for a part of the robot displaces it towards one side
of the pool. A keypoint that lies higher than the others is displaced away from the point below the
camera, in proportion to the distance from it. With p the position in the pool and p_0 the middle of
all positions, both are contained in

    d(p) = c + g (p - p_0).

Let d_f and d_b be the displacements of the front and the back end of a rigid length, and u the unit
vector from back to front. The measured length has the excess

    y = u' (d_f - d_b) + Z b + e    (Z b: `length_regression`).

The excess by c changes its sign when the robot turns by 180 degrees, and that by g when the robot
heads towards the camera instead of away from it. That of a camera error does not: a lens stretches
a length equally in both directions.

A displacement common to all keypoints does not change lengths, and a common growth g cannot be
distinguished from an error of the scale. Both are therefore given relative to the largest group of
keypoints that are not displaced relative to each other. Of two groups of the same size it is not
known which one is displaced; the corrected motion is the same.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.special import chdtri

from ..data import Float, Positions
from ..study import Robot
from .displacement_field import DisplacementField, without_displacements
from .length_regression import (
    DISPLACEMENT_STD_SHARE,
    by_keypoint,
    directions_of_lengths,
    length_misfit,
    length_of_rigid_parts_m,
    middle_of_lengths_m,
    regress_lengths,
)
from .length_windows import window_means
from .rigid_distances import RigidDistances, rigid_distances

MIN_SIGMAS = 5.0
"""Standard errors from 0 beyond which a keypoint counts as displaced. Fifteen studies
of `campus_pool` 5841, `tidal_lock` 9402 and `leading_plate` 5701, in which no keypoint is displaced
in this way, reach 2.5 with c and 2.2 with g (60 keypoints, relative to the mean of the others)."""
FALSE_ALARM_PROBABILITY = 6e-7
"""Probability with which a change within the session is found by chance: that of `MIN_SIGMAS`
standard deviations of a normal distribution."""
MIN_DISPLACEMENT_SHARE = 0.006
"""Smallest displacement that is corrected, over the length of the rigid parts from nose to tail:
2 mm for the published robot, whose keypoints are labelled to 1 mm in careful work. That by g is
taken at the root mean square distance from the middle."""
GROWTH_STD = 0.02
"""Prior standard deviation of g, wide: a keypoint 3 cm above the others, seen from 1.5 m."""
MAX_ESTIMATES, MAX_CHANGES_TRIED = 6, 40
DECIMALS = 4
"""Displacements are used to a tenth of a millimetre, and their growth to as much per metre: their
last digits change with every trial that is added, and each change places the keypoints of all
trials again."""
ROUNDING_VARIANCE_M2 = 0.1 ** (2 * DECIMALS) / 12.0


@dataclass(frozen=True)
class KeypointDisplacement:
    """Displacement (x, y) of a keypoint in the pool frame at the middle of all positions, m, and
    its growth with the distance from there, m per m. Each is 0 where it does not count. The
    standard errors include the rounding.

    middle_m: (x, y). sigmas: distance from 0 in standard errors, of the larger one.
    """

    x_m: float
    y_m: float
    x_std_m: float
    y_std_m: float
    growth: float
    growth_std: float
    middle_m: tuple[float, float]
    sigmas: float

    @property
    def field(self) -> DisplacementField:
        """The displacement at each position."""
        return DisplacementField(self.x_m, self.y_m, self.growth, *self.middle_m)


def displacements_by_part(
    trials: Sequence[Positions], head_lengths_m: Sequence[float], robot: Robot
) -> list[tuple[range, dict[str, KeypointDisplacement]]]:
    """Displaced keypoints of each part of the session (places in `trials`, in the order of filming)
    in which there are any. There is one part, or two where a displacement begins, ends or changes,
    as when a lamp is moved.

    Raises: InputError where no rigid pair is ever seen.
    """
    common = keypoint_displacements(trials, head_lengths_m, robot)
    corrected = [without_displacements(one, displacement_fields(common)) for one in trials]
    parts = _parts_of_session(corrected, head_lengths_m, robot)
    if len(parts) == 1:
        return [(parts[0], common)] if common else []
    each = [
        keypoint_displacements([trials[k] for k in part], [head_lengths_m[k] for k in part], robot)
        for part in parts
    ]
    if common and _agree(each[0], each[1], MIN_DISPLACEMENT_SHARE * robot.body_length_m):
        return [(range(len(trials)), common)]
    displaced = [(part, found) for part, found in zip(parts, each, strict=True) if found]
    return displaced or ([(range(len(trials)), common)] if common else [])


def _agree(
    one: Mapping[str, KeypointDisplacement], other: Mapping[str, KeypointDisplacement],
    least_m: float,
) -> bool:  # fmt: skip
    """Whether the same keypoints are displaced, in the middles of both parts of the session by
    vectors that differ by less than `least_m`.
    """
    return one.keys() == other.keys() and all(
        np.hypot(*np.subtract(_displacement_at(one[name], place),
                              _displacement_at(other[name], place))) < least_m
        for name in one for place in (one[name].middle_m, other[name].middle_m)
    )  # fmt: skip


def _displacement_at(found: KeypointDisplacement, place_m: tuple[float, float]) -> Float:
    away = np.subtract(place_m, found.middle_m)
    return np.asarray([found.x_m, found.y_m] + found.growth * away)


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
    names, columns, stds = displacement_columns(windows, middle_of_lengths_m(windows))
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
    fields: dict[str, DisplacementField] = {}
    found: dict[str, KeypointDisplacement] = {}
    middle_m = None
    for _ in range(MAX_ESTIMATES):
        corrected = [without_displacements(one, fields) for one in trials]
        windows = window_means(rigid_distances(corrected, head_lengths_m, robot))
        middle_m = middle_of_lengths_m(windows).round(DECIMALS) if middle_m is None else middle_m
        found = _displaced(windows, fields, middle_m)
        if displacement_fields(found) == fields:
            break
        fields = displacement_fields(found)
    return found


def displacement_fields(
    displaced: Mapping[str, KeypointDisplacement],
) -> dict[str, DisplacementField]:
    """Keypoint -> displacement at each position."""
    return {name: found.field for name, found in displaced.items()}


def _displaced(
    windows: RigidDistances, corrected: Mapping[str, DisplacementField], middle_m: Float
) -> dict[str, KeypointDisplacement]:
    """The keypoints that are displaced relative to most others, by what was corrected and what the
    lengths show in addition.
    """
    names, columns, stds = displacement_columns(windows, middle_m)
    if len(names) < 3:
        return {}
    estimate, cov, _ = regress_lengths(windows, columns, stds)
    vectors = estimate.reshape(-1, 3) + [corrected.get(name, (0.0,) * 3)[:3] for name in names]
    reference = _undisplaced(vectors, cov)
    found = {}
    for k, name in enumerate(names):
        one = _displacement(*_relative_to(vectors, cov, k, reference), windows, middle_m)
        if one.sigmas > 0 and k not in reference:
            found[name] = one
    return found


def _displacement(
    vector: Float, cov: Float, windows: RigidDistances, middle_m: Float
) -> KeypointDisplacement:
    """Displacement from its estimate (x, y, growth) and covariance (3, 3)."""
    least_m = MIN_DISPLACEMENT_SHARE * length_of_rigid_parts_m(windows)
    constant, growth = _sigmas(vector[:2], cov[:2, :2]), _sigmas(vector[2:], cov[2:, 2:])
    is_constant = constant > MIN_SIGMAS and np.hypot(*vector[:2]) > least_m
    grows = growth > MIN_SIGMAS and abs(vector[2]) * _rms_distance_m(windows, middle_m) > least_m
    counts = np.array([is_constant, is_constant, grows])
    x, y, g = (float(v) for v in np.where(counts, np.round(vector, DECIMALS), 0.0))
    x_std, y_std, g_std = (float(v) for v in np.sqrt(np.diag(cov) + ROUNDING_VARIANCE_M2))
    middle_x, middle_y = (float(v) for v in middle_m)
    sigmas = max(constant * is_constant, growth * grows)
    return KeypointDisplacement(x, y, x_std, y_std, g, g_std, (middle_x, middle_y), float(sigmas))


def _undisplaced(vectors: Float, cov: Float) -> tuple[int, ...]:
    """The largest group of keypoints whose vectors agree; of several of this size, that whose
    vectors agree best. Two keypoints are the least.
    """
    keypoints = range(len(vectors))
    for size in range(len(vectors), 2, -1):
        misfits = {group: _difference_misfit(vectors, cov, group)
                   for group in combinations(keypoints, size)}  # fmt: skip
        best = min(misfits, key=lambda group: misfits[group])
        if misfits[best] < chdtri(3 * (size - 1), FALSE_ALARM_PROBABILITY):
            return best
    pairs = list(combinations(keypoints, 2))
    return min(pairs, key=lambda group: _difference_misfit(vectors, cov, group))


def _difference_misfit(vectors: Float, cov: Float, group: Sequence[int]) -> float:
    """Chi-squared of the differences of vectors within a group."""
    count = len(vectors)
    weights = np.eye(count)[list(group[1:])] - np.eye(count)[group[0]]
    T = np.kron(weights, np.eye(3))
    differences = (weights @ vectors).ravel()
    return float(differences @ np.linalg.solve(T @ cov @ T.T, differences))


def _relative_to(
    vectors: Float, cov: Float, k: int, reference: Sequence[int]
) -> tuple[Float, Float]:
    """Displacement (x, y, growth) of keypoint k relative to the mean of others, and its covariance
    (3, 3).
    """
    weights = np.zeros(len(vectors))
    weights[list(reference)] = -1.0 / len(reference)
    weights[k] += 1.0
    T = np.kron(weights, np.eye(3))
    return np.asarray(weights @ vectors), np.asarray(T @ cov @ T.T)


def _sigmas(vector: Float, cov: Float) -> float:
    return float(np.sqrt(vector @ np.linalg.solve(cov, vector)))


def displacement_columns(
    windows: RigidDistances, middle_m: Float
) -> tuple[tuple[str, ...], Float, Float]:
    """Keypoints (k,) that were seen; excess (n, 3 k) of each length by a displacement of each of
    them by 1 m along x, along y, and by 1 m per m of distance from the middle; and prior standard
    deviations (3 k,).
    """
    u = directions_of_lengths(windows)
    front, back = (np.column_stack([u, np.sum(u * (end - middle_m), axis=1)])
                   for end in (windows.front_m, windows.back_m))  # fmt: skip
    patterns = {name: p for name, p in by_keypoint(windows, front, back).items() if p.any()}
    std_m = DISPLACEMENT_STD_SHARE * length_of_rigid_parts_m(windows)
    stds = np.tile([std_m, std_m, GROWTH_STD], len(patterns))
    return tuple(patterns), np.column_stack(list(patterns.values())), stds


def _rms_distance_m(windows: RigidDistances, middle_m: Float) -> float:
    """Root mean square distance of the lengths from the middle."""
    away = 0.5 * (windows.front_m + windows.back_m) - middle_m
    return float(np.sqrt(np.mean(np.sum(away**2, axis=1))))
