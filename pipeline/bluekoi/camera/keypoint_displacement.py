"""Keypoints that are displaced from their place on the robot as a function of place in the pool.

A detector that takes a highlight or a shadow for a part of the robot displaces it towards one side
of the pool. A keypoint that lies higher than the others is displaced away from the point below the
camera, in proportion to the distance from it. With p the position in the pool and p_0 the mean
position of the lengths, both are contained in

    d(p) = c + g (p - p_0).

Let d_f and d_b be the displacements of the front and the back end of a rigid length, and u the unit
vector from back to front. The measured length has the excess

    y = u' (d_f - d_b) + Z b + e    (Z b: `rigid_length_regression`).

The excess by c changes its sign when the robot turns by 180 degrees, and that by g when the robot
heads towards the point below the camera instead of away from it. That of a camera error does not: a
lens stretches a length equally in both directions.

A displacement common to all keypoints does not change lengths, and a common parallax g cannot be
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

from ..data import Float, KeypointPositions
from ..study import Robot
from .keypoint_displacement_field import (
    NO_DISPLACEMENT,
    KeypointDisplacementField,
    remove_keypoint_displacements,
)
from .rigid_distances import RigidDistances, rigid_distances
from .rigid_length_regression import (
    DISPLACEMENT_PRIOR_STD_SHARE,
    directions_of_lengths,
    end_columns_by_keypoint,
    regress_length_errors,
    total_rigid_length_m,
)
from .rigid_length_windows import window_means

MIN_DISPLACEMENT_SIGMAS = 5.0
"""Standard errors from 0 beyond which a keypoint counts as displaced. Fifteen studies
of `campus_pool` 5841, `tidal_lock` 9402 and `leading_plate` 5701, in which no keypoint is displaced
in this way, reach 2.5 with c and 2.2 with g (60 keypoints, relative to the mean of the others)."""
FALSE_ALARM_PROBABILITY = 6e-7
"""Probability with which keypoints that agree are found to differ: that of
`MIN_DISPLACEMENT_SIGMAS` standard deviations of a normal distribution."""
MIN_DISPLACEMENT_LENGTH_SHARE = 0.006
"""Smallest displacement that is corrected, over the length of the rigid parts from nose to tail:
2 mm for the published robot, whose keypoints are labelled to 1 mm in careful work. That by g is
taken at the root mean square distance from p_0."""
MIN_KEYPOINTS = 3
"""Of two keypoints it is not known which one is displaced."""
PARALLAX_PRIOR_STD = 0.02
"""Prior standard deviation of g: a keypoint 3 cm above the others, seen from 1.5 m. The lengths of
those fifteen studies determine g to 3e-4 or better, so that the prior does not matter."""
MAX_DISPLACEMENT_ITERATIONS = 6
"""Limit of the computing time. An estimate that still changes by the smallest displacement is not
used."""
DISPLACEMENT_DECIMALS = 4
"""Displacements are used to a tenth of a millimetre, and the parallax to as much per metre: their
last digits change with every trial that is added, and each change places the keypoints of all
trials again."""
ROUNDING_VARIANCE = 0.1 ** (2 * DISPLACEMENT_DECIMALS) / 12.0


@dataclass(frozen=True)
class KeypointDisplacementEstimate:
    """Displacement (x, y) of a keypoint at the origin of the pool frame, m, and its parallax, m per
    m; 0 where the displacement is constant. The standard errors include the rounding.

    sigmas: distance of c or g from 0 in standard errors, the larger of those that count.
    """

    x_m: float
    y_m: float
    x_std_m: float
    y_std_m: float
    parallax: float
    parallax_std: float
    sigmas: float

    @property
    def field(self) -> KeypointDisplacementField:
        """The displacement at each position."""
        return KeypointDisplacementField(self.x_m, self.y_m, self.parallax)


def estimate_keypoint_displacements(
    trials: Sequence[KeypointPositions], head_lengths_m: Sequence[float], robot: Robot
) -> dict[str, KeypointDisplacementEstimate]:
    """The displaced keypoints by name; none where fewer than three keypoints are connected by
    lengths, or where the estimates do not converge.

    The estimate is repeated with corrected positions, since the directions and head angles of the
    first one are those of displaced keypoints.

    Raises: InputError where no rigid pair is ever seen.
    """
    fields: dict[str, KeypointDisplacementField] = {}
    for _ in range(MAX_DISPLACEMENT_ITERATIONS):
        corrected = [remove_keypoint_displacements(one, fields) for one in trials]
        windows = window_means(rigid_distances(corrected, head_lengths_m, robot))
        before, found = fields, _displaced_keypoints(windows, fields)
        fields = displacement_fields(found)
        if fields == before:
            break
    return found if same_displacements(before, fields, windows) else {}


def displacement_fields(
    displaced: Mapping[str, KeypointDisplacementEstimate],
) -> dict[str, KeypointDisplacementField]:
    """Keypoint -> displacement at each position."""
    return {name: found.field for name, found in displaced.items()}


def same_displacements(
    one: Mapping[str, KeypointDisplacementField],
    other: Mapping[str, KeypointDisplacementField],
    windows: RigidDistances,
) -> bool:
    """Whether the same keypoints are displaced, at the places of the lengths by vectors whose root
    mean square difference is below the smallest displacement that is corrected.
    """
    places, least_m = windows.centers_m, min_corrected_displacement_m(windows)
    return one.keys() == other.keys() and all(
        _rms_m(one[name].at(places) - other[name].at(places)) < least_m for name in one
    )


def displacements_identifiable(distances: RigidDistances) -> bool:
    """Whether lengths connect enough keypoints to show which of them are displaced."""
    return len(displacement_design_matrix(distances)[0]) >= MIN_KEYPOINTS


def min_corrected_displacement_m(windows: RigidDistances) -> float:
    """Smallest displacement that is corrected."""
    return MIN_DISPLACEMENT_LENGTH_SHARE * total_rigid_length_m(windows)


def _displaced_keypoints(
    windows: RigidDistances, corrected: Mapping[str, KeypointDisplacementField]
) -> dict[str, KeypointDisplacementEstimate]:
    """The keypoints that are displaced relative to most others, by what was corrected and what the
    lengths show in addition.
    """
    names, columns, stds = displacement_design_matrix(windows)
    if len(names) < MIN_KEYPOINTS:
        return {}
    estimate, cov, _ = regress_length_errors(windows, columns, stds)
    mean_position = windows.centers_m.mean(axis=0)
    known = [corrected.get(name, NO_DISPLACEMENT) for name in names]
    before = [[*field.at(mean_position), field.parallax] for field in known]
    vectors = estimate.reshape(-1, 3) + before
    reference = _largest_agreeing_keypoint_group(vectors, cov)
    found = {}
    for k in sorted(set(range(len(names))) - set(reference)):
        one = _significant_displacement(
            *_displacement_from_group(vectors, cov, k, reference), windows
        )
        if one is not None:
            found[names[k]] = one
    return found


def _significant_displacement(
    vector: Float, cov: Float, windows: RigidDistances
) -> KeypointDisplacementEstimate | None:
    """Displacement from c and g (3,) and their covariance (3, 3); None where neither counts. g is 0
    where it does not count.
    """
    places, least_m = windows.centers_m, min_corrected_displacement_m(windows)
    mean_position = places.mean(axis=0)
    constant, parallax = (
        _distance_in_std_errors(vector[:2], cov[:2, :2]),
        _distance_in_std_errors(vector[2:], cov[2:, 2:]),
    )
    is_displaced = constant > MIN_DISPLACEMENT_SIGMAS and np.hypot(*vector[:2]) > least_m
    by_parallax = vector[2] * (places - mean_position)
    has_parallax = parallax > MIN_DISPLACEMENT_SIGMAS and _rms_m(by_parallax) > least_m
    if not (is_displaced or has_parallax):
        return None
    sigmas = float(max(constant * is_displaced, parallax * has_parallax))
    g = float(np.round(vector[2], DISPLACEMENT_DECIMALS)) if has_parallax else 0.0
    x, y = (float(v) for v in np.round(vector[:2] - g * mean_position, DISPLACEMENT_DECIMALS))
    T = np.column_stack([np.eye(2), -mean_position * has_parallax])  # a = c - g p_0
    x_std, y_std = (float(v) for v in np.sqrt(np.diag(T @ cov @ T.T) + ROUNDING_VARIANCE))
    g_std = float(np.sqrt(cov[2, 2] + ROUNDING_VARIANCE))
    return KeypointDisplacementEstimate(x, y, x_std, y_std, g, g_std, sigmas)


def _largest_agreeing_keypoint_group(vectors: Float, cov: Float) -> tuple[int, ...]:
    """The largest group of keypoints whose vectors agree; of several of this size, that whose
    vectors agree best. Two keypoints are the least. Of several pairs that agree, it is that nearest
    to the tail: repeated estimates that change from pair to pair would not converge.
    """
    keypoints = range(len(vectors))
    for size in range(len(vectors), 2, -1):
        misfits = {group: _chi_squared_of_differences(vectors, cov, group)
                   for group in combinations(keypoints, size)}  # fmt: skip
        best = min(misfits, key=lambda group: misfits[group])
        if misfits[best] < chdtri(3 * (size - 1), FALSE_ALARM_PROBABILITY):
            return best
    misfits = {
        pair: _chi_squared_of_differences(vectors, cov, pair) for pair in combinations(keypoints, 2)
    }
    agreeing = [pair for pair in misfits if misfits[pair] < chdtri(3, FALSE_ALARM_PROBABILITY)]
    return agreeing[-1] if agreeing else min(misfits, key=lambda pair: misfits[pair])


def _chi_squared_of_differences(vectors: Float, cov: Float, group: Sequence[int]) -> float:
    """Chi-squared of the differences of vectors within a group."""
    count = len(vectors)
    weights = np.eye(count)[list(group[1:])] - np.eye(count)[group[0]]
    T = np.kron(weights, np.eye(3))
    differences = (weights @ vectors).ravel()
    return float(differences @ np.linalg.solve(T @ cov @ T.T, differences))


def _displacement_from_group(
    vectors: Float, cov: Float, k: int, reference: Sequence[int]
) -> tuple[Float, Float]:
    """C and g (3,) of keypoint k relative to the mean of others, and their covariance (3, 3)."""
    weights = np.zeros(len(vectors))
    weights[list(reference)] = -1.0 / len(reference)
    weights[k] += 1.0
    T = np.kron(weights, np.eye(3))
    return np.asarray(weights @ vectors), np.asarray(T @ cov @ T.T)


def _distance_in_std_errors(vector: Float, cov: Float) -> float:
    return float(np.sqrt(vector @ np.linalg.solve(cov, vector)))


def displacement_design_matrix(windows: RigidDistances) -> tuple[tuple[str, ...], Float, Float]:
    """Keypoints (k,) that were seen; excess (n, 3 k) of each length by a displacement of each of
    them by 1 m along x, along y, and by a parallax of 1 about the mean position; and prior standard
    deviations (3 k,).
    """
    u, mean_position = directions_of_lengths(windows), windows.centers_m.mean(axis=0)
    front, back = (np.column_stack([u, np.sum(u * (end - mean_position), axis=1)])
                   for end in (windows.front_m, windows.back_m))  # fmt: skip
    patterns = {
        name: p for name, p in end_columns_by_keypoint(windows, front, back).items() if p.any()
    }
    std_m = DISPLACEMENT_PRIOR_STD_SHARE * total_rigid_length_m(windows)
    stds = np.tile([std_m, std_m, PARALLAX_PRIOR_STD], len(patterns))
    return tuple(patterns), np.column_stack(list(patterns.values())), stds


def _rms_m(vectors_m: Float) -> float:
    """Root mean square length of vectors (n, 2)."""
    return float(np.sqrt(np.mean(np.sum(vectors_m**2, axis=1))))
