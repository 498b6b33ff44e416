"""Regression of the tail's angle on a beat and a slow background, as the camera sees them."""

from __future__ import annotations

import numpy as np

from ..data import Float, Pose, Positions, is_confident
from .shaft_angle import wrap_angle

TAIL_ANGLE_KEYPOINTS = ("tail_tip", "tail_base", "core_center")
"""Keypoints between which the tail's angle is measured."""
FREQUENCIES_PER_BATCH = 256
"""Frequencies whose spectrum is computed at once, to bound memory."""
BACKGROUND_PERIOD_BEATS = 3.0
"""The slow background has one spline knot per so many beats."""


def beat_signal(source: Positions | Pose) -> tuple[Float, Float]:
    """Times and beating angle (rad) in the frames where it is seen."""
    if isinstance(source, Pose):
        angle = source.values[:, 2]
    elif set(TAIL_ANGLE_KEYPOINTS) <= set(source.names):
        angle = tail_angle(source)
    else:
        return np.zeros(0), np.zeros(0)
    seen = np.isfinite(angle)
    return source.time_s[seen], angle[seen]


def tail_angle(positions: Positions) -> Float:
    """Angle of the tail to the core (frames,), rad; NaN where a keypoint is not seen."""
    tail = positions.part("tail_tip") - positions.part("tail_base")
    core = positions.part("tail_base") - positions.part("core_center")
    sure = is_confident(
        positions.likelihood[:, [positions.names.index(n) for n in TAIL_ANGLE_KEYPOINTS]]
    ).all(axis=1)
    angle = wrap_angle(np.arctan2(tail[:, 1], tail[:, 0]) - np.arctan2(core[:, 1], core[:, 0]))
    return np.where(sure, angle, np.nan)


def slow_trend_basis(time_s: Float, reference_hz: float) -> Float:
    """Slow curve: low cosines (Chebyshev in time), (frames, terms)."""
    span = float(np.ptp(time_s))
    terms = int(np.clip(span * reference_hz / BACKGROUND_PERIOD_BEATS, 2, 12))
    scaled = 2 * (time_s - time_s[0]) / span - 1
    return np.polynomial.chebyshev.chebvander(scaled, terms)


def robust_weights(residual: Float) -> Float:
    """Weights that fall with the residual squared beyond 2.5 robust deviations."""
    scale = max(1.4826 * float(np.median(np.abs(residual))), 1e-12)
    return np.asarray(1.0 / np.maximum(1.0, (np.abs(residual) / (2.5 * scale)) ** 2))


def misfit_spectrum(
    hz: Float, time_s: Float, signal: Float, background: Float, weights: Float
) -> Float:
    """Weighted sum of squares that background and a line leave, for each frequency of `hz`.

    Line and signal are projected off the background first; 2 x 2 normal equations remain.
    """
    root = np.sqrt(weights)
    basis = np.linalg.qr(background * root[:, None])[0]
    rest = signal * root - basis @ (basis.T @ (signal * root))
    left = np.empty(len(hz))
    for first in range(0, len(hz), FREQUENCIES_PER_BATCH):
        some = slice(first, first + FREQUENCIES_PER_BATCH)
        wave = root[:, None] * np.exp(2j * np.pi * np.outer(time_s - time_s.mean(), hz[some]))
        wave -= basis @ (basis.T @ wave)
        c, s = wave.real, wave.imag
        cc, ss, cs = (c * c).sum(0), (s * s).sum(0), (c * s).sum(0)
        cy, sy = rest @ c, rest @ s
        det = np.maximum(cc * ss - cs**2, 1e-9 * cc * ss + 1e-300)
        left[some] = rest @ rest - (ss * cy**2 - 2 * cs * cy * sy + cc * sy**2) / det
    return left
