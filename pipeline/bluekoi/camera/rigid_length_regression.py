"""Linear regression of the excess of rigid lengths on what may change them.

With y the excess of the measured lengths (means over short windows of all trials),

    y = X a + Z b + e,    b ~ N(0, S),    e ~ N(0, N).

X are the changes that are sought, and Z b what else may change lengths: keypoints displaced on the
body, and stretches of the picture that vary with place and direction.
"""

from __future__ import annotations

import numpy as np

from ..data import Float
from .geometry_hypotheses import SYSTEMATIC_LENGTH_ERROR_SHARE
from .rigid_distances import RIGID_PAIRS, RigidDistances, length_sensitivity_to_keypoint_shift

DISPLACEMENT_PRIOR_STD_SHARE = 0.1
"""Prior standard deviation of a displacement of a keypoint over the length of the rigid parts:
wide."""
IMAGE_STRETCH_PRIOR_STD = 0.02
"""Prior standard deviation of a relative stretch, wide."""
NOISE_ITERATIONS = 3
CHI2_1_DF_MEDIAN = 0.455


def regress_length_errors(
    windows: RigidDistances, patterns: Float, prior_stds: Float
) -> tuple[Float, Float, Float]:
    """Estimates a (k,), their covariance (k, k), and the variance (n,) of the lengths, for patterns
    X (n, k) with prior standard deviations (k,).

    The covariance is the sum of the scatter between trials (sandwich with trials as clusters) and
    that of the model. The scatter of the lengths is estimated from the median of the squared
    errors.
    """
    k = patterns.shape[1]
    X, prior = _append_nuisance_regressors(windows, patterns, prior_stds)
    variance = windows.std_m**2 + (SYSTEMATIC_LENGTH_ERROR_SHARE * windows.known_m) ** 2
    for _ in range(NOISE_ITERATIONS):
        weighted = (X / variance[:, None]).T
        A = weighted @ X + np.diag(prior)
        b = np.linalg.solve(A, weighted @ windows.excess_m)
        e = windows.excess_m - X @ b
        variance = variance * max(1.0, float(np.median(e**2 / variance)) / CHI2_1_DF_MEDIAN)
    trials = [windows.trial == trial for trial in np.unique(windows.trial)]
    gradients = np.array([weighted[:, own] @ e[own] for own in trials])
    inverse = np.linalg.inv(A)
    cov = inverse @ (gradients.T @ gradients + A) @ inverse
    return np.asarray(b[:k]), np.asarray(cov[:k, :k]), np.asarray(variance)


def length_misfit(
    windows: RigidDistances, patterns: Float, prior_stds: Float, variance: Float
) -> float:
    """Sum of squared errors over their variance (n,), and of squared coefficients over that of the
    prior, at the most probable coefficients.
    """
    X, prior = _append_nuisance_regressors(windows, patterns, prior_stds)
    weighted = (X / variance[:, None]).T
    A = weighted @ X + np.diag(prior)
    cross = weighted @ windows.excess_m
    return float(
        windows.excess_m @ (windows.excess_m / variance) - cross @ np.linalg.solve(A, cross)
    )


def total_rigid_length_m(windows: RigidDistances) -> float:
    """Sum of the known lengths, m, of all parts that were seen."""
    pair = windows.pair.round()
    return float(sum(np.median(windows.known_m[pair == k]) for k in np.unique(pair)))


def directions_of_lengths(windows: RigidDistances) -> Float:
    """Unit vectors (n, 2) from back to front."""
    along = windows.front_m - windows.back_m
    return np.asarray(along / np.linalg.norm(along, axis=1)[:, None])


def end_columns_by_keypoint(windows: RigidDistances, front: Float, back: Float) -> dict[str, Float]:
    """Keypoint -> `front` where it is the front end of a length, minus `back` where the back end;
    (n, k) each.
    """
    patterns: dict[str, Float] = {}
    for number, pair in enumerate(RIGID_PAIRS):
        own = (windows.pair.round() == number)[:, None]
        for name, part in zip(pair, (front, -back), strict=True):
            patterns[name] = patterns.get(name, 0.0) + own * part
    return patterns


def _append_nuisance_regressors(
    windows: RigidDistances, patterns: Float, prior_stds: Float
) -> tuple[Float, Float]:
    """Patterns X and Z (n, k + z) side by side, and their prior precisions (k + z,)."""
    others, stds = _nuisance_regressors(windows)
    return np.column_stack([patterns, others]), np.concatenate([prior_stds, stds]) ** -2.0


def _nuisance_regressors(windows: RigidDistances) -> tuple[Float, Float]:
    """Z (n, z) of the other changes of lengths, and their prior standard deviations (z,)."""
    u, pair = directions_of_lengths(windows), windows.pair.round()
    body_m = total_rigid_length_m(windows)
    centers = windows.centers_m
    on_body = [*length_sensitivity_to_keypoint_shift(windows).values(),
               np.where(pair == 0, np.sin(windows.bend_rad), 0.0)]  # fmt: skip
    away = centers - centers.mean(axis=0)
    x, y = (away / np.maximum(np.ptp(centers, axis=0), body_m)).T * 2.0
    ones = np.ones_like(x)
    directions = (ones, u[:, 0] ** 2 - u[:, 1] ** 2, 2.0 * u[:, 0] * u[:, 1])
    places = (ones, x, y, x * x, x * y, y * y)
    stretches = [windows.known_m * place * way for place in places for way in directions]
    columns = np.column_stack([*on_body, *stretches])
    stds = np.repeat(
        [DISPLACEMENT_PRIOR_STD_SHARE * body_m, IMAGE_STRETCH_PRIOR_STD],
        [len(on_body), len(stretches)],
    )
    return columns, stds
