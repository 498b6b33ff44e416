"""Regression of the tail's angle on a beat and a slow background, as the camera sees them."""

from __future__ import annotations

import numpy as np

from ..data import Float, KeypointPositions, Pose, is_confident
from .shaft_angle import wrap_angle

TAIL_ANGLE_KEYPOINTS = ("tail_tip", "tail_base", "core_center")
"""Keypoints between which the tail's angle is measured."""
FREQUENCIES_PER_BATCH = 32
"""Frequencies whose spectrum is computed at once: their arrays stay in the cache."""
BEATS_PER_SLOW_TREND_TERM = 3.0
"""Beats per term of the Chebyshev polynomial that describes the slow background."""


def beat_signal(source: KeypointPositions | Pose) -> tuple[Float, Float]:
    """Times and beating angle (rad) in the frames where it is seen."""
    if isinstance(source, Pose):
        angle = source.values[:, 2]
    elif set(TAIL_ANGLE_KEYPOINTS) <= set(source.names):
        angle = tail_angle(source)
    else:
        return np.zeros(0), np.zeros(0)
    seen = np.isfinite(angle)
    return source.time_s[seen], angle[seen]


def tail_angle(positions: KeypointPositions) -> Float:
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
    terms = int(np.clip(span * reference_hz / BEATS_PER_SLOW_TREND_TERM, 2, 12))
    scaled = 2 * (time_s - time_s[0]) / span - 1
    return np.polynomial.chebyshev.chebvander(scaled, terms)


def robust_weights(residual: Float) -> Float:
    """Weights that fall with the residual squared beyond 2.5 robust deviations."""
    scale = max(1.4826 * float(np.median(np.abs(residual))), 1e-12)
    return np.asarray(1.0 / np.maximum(1.0, (np.abs(residual) / (2.5 * scale)) ** 2))


def misfit_spectrum(
    hz: Float, time_s: Float, signal: Float, background: Float, weights: Float
) -> Float:
    """Weighted sum of squares that background and a line leave, for each of evenly spaced
    frequencies `hz`.

    Line and signal are projected off the background first; 2 x 2 normal equations remain. With an
    orthonormal basis B of the weighted background, the sums of squares and products of the
    projected cosine c and sine s are those of c and s less those of B' c and B' s.
    """
    root = np.sqrt(weights)
    basis = np.linalg.qr(background * root[:, None])[0]
    rest = signal * root - basis @ (basis.T @ (signal * root))
    rows = np.column_stack([basis, rest]) * root[:, None]
    left = np.empty(len(hz))
    for first in range(0, len(hz), FREQUENCIES_PER_BATCH):
        some = slice(first, first + FREQUENCIES_PER_BATCH)
        c, s = _cosines_and_sines(hz[some], time_s - time_s.mean())
        along_c, along_s = c @ rows, s @ rows
        cy, sy = along_c[:, -1], along_s[:, -1]
        whole = (c * c) @ weights
        cc = whole - np.sum(along_c[:, :-1] ** 2, axis=1)
        ss = weights.sum() - whole - np.sum(along_s[:, :-1] ** 2, axis=1)
        cs = (c * s) @ weights - np.sum(along_c[:, :-1] * along_s[:, :-1], axis=1)
        det = np.maximum(cc * ss - cs**2, 1e-9 * cc * ss + 1e-300)
        left[some] = rest @ rest - (ss * cy**2 - 2 * cs * cy * sy + cc * sy**2) / det
    return left


def _cosines_and_sines(hz: Float, time_s: Float) -> tuple[Float, Float]:
    """Cosine and sine of 2 pi f t (frequencies, frames) at evenly spaced frequencies, by the
    addition theorems from those of few coarse and few fine steps of the frequency.
    """
    step = hz[1] - hz[0] if len(hz) > 1 else 0.0
    fine = int(np.ceil(np.sqrt(len(hz))))
    coarse = -(-len(hz) // fine)
    a = 2 * np.pi * np.outer(hz[0] + step * fine * np.arange(coarse), time_s)[:, None]
    b = 2 * np.pi * np.outer(step * np.arange(fine), time_s)[None]
    ca, sa, cb, sb = np.cos(a), np.sin(a), np.cos(b), np.sin(b)
    c, s = ca * cb - sa * sb, sa * cb + ca * sb
    return c.reshape(-1, len(time_s))[: len(hz)], s.reshape(-1, len(time_s))[: len(hz)]
