"""Keypoints that are displaced from their place on the robot by a constant vector in the pool.

A detector that takes a highlight or a shadow for a part of the robot displaces it towards one side
of the pool, whatever the heading of the robot. Let d_f and d_b be the displacements of the front
and the back end of a rigid length, and u the unit vector from back to front. The measured length
has the excess

    y = u' (d_f - d_b) + Z b + e,    b ~ N(0, S),    e ~ N(0, N).

This excess changes its sign when the robot turns by 180 degrees. That of a camera error does not: a
lens stretches a length equally in both directions. Z b is what else changes lengths: keypoints
displaced on the body, keypoints at different heights (displaced away from the point below the
camera, in proportion to the distance from it), and stretches that vary with place and direction.

A displacement common to all keypoints does not change lengths. The vectors d are therefore given
relative to their median: one displaced keypoint has a vector, the others have none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..data import Float, Positions
from ..study import Robot
from .geometry_hypotheses import SYSTEMATIC_LENGTH_ERROR_SHARE
from .length_windows import window_means
from .rigid_distances import (
    RIGID_PAIRS,
    RigidDistances,
    length_excess_by_keypoint_shift,
    rigid_distances,
)

MIN_SIGMAS = 5.0
"""Standard errors from 0 beyond which a keypoint counts as displaced. Fifteen studies
of `campus_pool` 5841, `tidal_lock` 9402 and `leading_plate` 5701, in which no keypoint is displaced
in this way, reach 2.4 (60 keypoints)."""
MIN_DISPLACEMENT_SHARE = 0.01
"""Smallest displacement that is corrected, over the length of the core from hinge to tail base:
2 mm for the published robot, whose keypoints are labelled to 1 mm in careful work."""
DISPLACEMENT_STD_SHARE = 0.1
"""Prior standard deviation of a displacement, in the pool or on the body, over the core's length:
wide."""
STRETCH_STD, RELATIVE_HEIGHT_STD = 0.02, 0.02
"""Prior standard deviations, wide: of a relative stretch, and of a keypoint's height above the
others over the height of the camera (3 cm seen from 1.5 m)."""
MAX_ESTIMATES, NOISE_ITERATIONS = 6, 3
CHI2_1_DF_MEDIAN = 0.455
DECIMALS = 3
"""Displacements are used to the millimetre, as the depth is: their last digits change with every
trial that is added, and each change would place the keypoints of all trials again."""


@dataclass(frozen=True)
class KeypointDisplacement:
    """Displacement (x, y) of a keypoint in the pool frame, with its standard errors, m.

    sigmas: distance from 0 in standard errors.
    """

    x_m: float
    y_m: float
    x_std_m: float
    y_std_m: float
    sigmas: float


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
        found = _displaced(_remaining_vectors(windows), vectors, _length_of_core_m(windows))
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


def _remaining_vectors(windows: RigidDistances) -> dict[str, tuple[Float, Float]]:
    """Keypoint -> displacement (2,) relative to the median of all, m, and covariance (2, 2)."""
    patterns = {name: p for name, p in _displacement_patterns(windows).items() if p.any()}
    if len(patterns) < 3:
        return {}
    estimate, cov = _estimate(windows, np.column_stack(list(patterns.values())))
    vectors = estimate.reshape(-1, 2)
    vectors = vectors - np.median(vectors, axis=0)
    return {name: (vectors[k], _relative_covariance(cov, k)) for k, name in enumerate(patterns)}


def _displaced(
    remaining: Mapping[str, tuple[Float, Float]],
    corrected: Mapping[str, tuple[float, float]],
    core_m: float,
) -> dict[str, KeypointDisplacement]:
    """The keypoints that are displaced, by what was corrected and what remains."""
    found = {}
    for name, (vector, cov) in remaining.items():
        whole = vector + np.array(corrected.get(name, (0.0, 0.0)))
        sigmas = float(np.sqrt(whole @ np.linalg.solve(cov, whole)))
        if sigmas > MIN_SIGMAS and np.hypot(*whole) > MIN_DISPLACEMENT_SHARE * core_m:
            x, y = np.round(whole, DECIMALS)
            x_std, y_std = np.sqrt(np.diag(cov))
            found[name] = KeypointDisplacement(
                float(x), float(y), float(x_std), float(y_std), sigmas
            )
    return found


def _length_of_core_m(windows: RigidDistances) -> float:
    """Known length from hinge to tail base, m, of those of its parts that were seen."""
    pair = windows.pair.round()
    parts = [np.median(windows.known_m[pair == k]) for k in (1, 2) if (pair == k).any()]
    return float(sum(parts))


def _directions(windows: RigidDistances) -> Float:
    """Unit vectors (n, 2) from back to front."""
    along = windows.front_m - windows.back_m
    return np.asarray(along / np.linalg.norm(along, axis=1)[:, None])


def _displacement_patterns(windows: RigidDistances) -> dict[str, Float]:
    """Keypoint -> excess (n, 2) of each length by a displacement of 1 m along x and along y."""
    return _by_keypoint(windows, *[_directions(windows)] * 2)


def _by_keypoint(windows: RigidDistances, front: Float, back: Float) -> dict[str, Float]:
    """Keypoint -> `front` where it is the front end of a length, minus `back` where the back end;
    (n, k) each.
    """
    patterns: dict[str, Float] = {}
    for number, pair in enumerate(RIGID_PAIRS):
        own = (windows.pair.round() == number)[:, None]
        for name, part in zip(pair, (front, -back), strict=True):
            patterns[name] = patterns.get(name, 0.0) + own * part
    return patterns


def _other_patterns(windows: RigidDistances) -> tuple[Float, Float]:
    """Z (n, z) of the other changes of lengths, and their prior standard deviations (z,)."""
    u, pair, core_m = _directions(windows), windows.pair.round(), _length_of_core_m(windows)
    middle = 0.5 * (windows.front_m + windows.back_m)
    center = middle.mean(axis=0)
    on_body = [*length_excess_by_keypoint_shift(windows).values(),
               np.where(pair == 0, np.sin(windows.bend_rad), 0.0)]  # fmt: skip
    outwards = [np.sum(u * (end - center), axis=1)[:, None]
                for end in (windows.front_m, windows.back_m)]  # fmt: skip
    heights = [pattern[:, 0] for pattern in _by_keypoint(windows, *outwards).values()]
    x, y = ((middle - center) / np.maximum(np.ptp(middle, axis=0), core_m)).T * 2.0
    ones = np.ones_like(x)
    directions = (ones, u[:, 0] ** 2 - u[:, 1] ** 2, 2.0 * u[:, 0] * u[:, 1])
    places = (ones, x, y, x * x, x * y, y * y)
    stretches = [windows.known_m * place * way for place in places for way in directions]
    columns = np.column_stack([*on_body, *heights, *stretches])
    stds = np.repeat(
        [DISPLACEMENT_STD_SHARE * core_m, RELATIVE_HEIGHT_STD, STRETCH_STD],
        [len(on_body), len(heights), len(stretches)],
    )
    return columns, stds


def _estimate(windows: RigidDistances, patterns: Float) -> tuple[Float, Float]:
    """Displacements (k,) and their covariance (k, k).

    The covariance holds the scatter between trials (sandwich with trials as clusters) and that of
    the model. The scatter of the lengths is estimated from the median of the squared errors.
    """
    others, stds = _other_patterns(windows)
    k = patterns.shape[1]
    X = np.column_stack([patterns, others])
    displacement_std_m = DISPLACEMENT_STD_SHARE * _length_of_core_m(windows)
    prior = np.concatenate([np.full(k, displacement_std_m), stds]) ** -2.0
    variance = windows.std_m**2 + (SYSTEMATIC_LENGTH_ERROR_SHARE * windows.known_m) ** 2
    for _ in range(NOISE_ITERATIONS):
        weighted = (X / variance[:, None]).T
        A = weighted @ X + np.diag(prior)
        b = np.linalg.solve(A, weighted @ windows.excess_m)
        e = windows.excess_m - X @ b
        variance = variance * max(1.0, float(np.median(e**2 / variance)) / CHI2_1_DF_MEDIAN)
    gradients = np.array([weighted[:, own] @ e[own] for t in np.unique(windows.trial)
                          if (own := windows.trial == t).any()])  # fmt: skip
    inverse = np.linalg.inv(A)
    cov = inverse @ (gradients.T @ gradients + A) @ inverse
    return np.asarray(b[:k]), np.asarray(cov[:k, :k])


def _relative_covariance(cov: Float, k: int) -> Float:
    """Covariance (2, 2) of the displacement of keypoint k relative to the mean of the others."""
    count = len(cov) // 2
    weights = np.full(count, -1.0 / (count - 1))
    weights[k] = 1.0
    T = np.kron(weights, np.eye(2))
    return np.asarray(T @ cov @ T.T)
