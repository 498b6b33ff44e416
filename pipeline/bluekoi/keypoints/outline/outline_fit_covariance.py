"""How wrong a fitted pose is, from the offsets that it leaves along the outline.

Offsets e of the outline's points have covariance V = sum of s_k K_k: noise of each point alone (K_0
= 1), and light and shadow that lie unevenly over the picture, so that whole stretches of edge move
together: outwards or inwards (K_1 = exp(-(distance / scale_1)^2 / 2)), or one way, an edge with the
one opposite (K_2 = n n' exp(-(distance / scale_2)^2 / 2), n the normals). The fit takes A e for a
change of pose and leaves r = M e, M = 1 - X A. Since E[r' K_j r] = sum of tr(K_j M K_k M') s_k, the
variances s_k follow from the offsets left, what the fit has swallowed included, and A V A' is the
covariance of the pose. Source: quadratic unbiased estimation of variance components, C. R. Rao,
Journal of Multivariate Analysis 1 (1971) 257-275.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from ...data import Float
from ...numba_settings import njit

PATCH_LENGTH_SHARE, DRIFT_LENGTH_SHARE = 0.045, 0.11
"""Scales of light that moves edges in or out, and one way, as shares of head and core's length."""
MAX_SQUARED_RESIDUAL_TO_MEDIAN = 9.0


@dataclass(frozen=True)
class FrameQuadraticForms:
    """What one frame's offsets say of the variances, for K kernels.

    forms: (K,) r' K_j r, px^2. expected: (K, K) of them for each variance 1. spread: (K, 5, 5)
    A K_k A', covariance of pose and width in body axes for each variance 1.
    """

    forms: Float
    expected: Float
    spread: Float


def covariance_kernels(points_bl: Float, normals: Float, length_bl: float) -> Float:
    """Kernels (K, n, n) of outline points (n, 2), outward normals (n, 2), of a body of a length:
    own noise, light that moves edges in or out, light that moves them one way.
    """
    apart = np.hypot(*(points_bl[:, None] - points_bl).transpose(2, 0, 1)) / length_bl
    patch, drift = (
        np.exp(-0.5 * (apart / scale) ** 2) for scale in (PATCH_LENGTH_SHARE, DRIFT_LENGTH_SHARE)
    )
    return np.stack([np.eye(len(points_bl)), patch, drift * (normals @ normals.T)])


def frame_quadratic_forms(
    found: tuple[Float, Float, Float], heading: float, prior: Float, known: Float
) -> FrameQuadraticForms:
    """Statistics of one fitted frame.

    found: offsets left (n,) px, weights (n,), slopes (n, 5) in pool axes. heading: rad, of the
    core. prior: (5,) information of the fit's prior. known: (K, n, n) kernels.
    """
    return FrameQuadraticForms(*_summed_quadratic_forms(found, heading, np.diag(prior), known))


@njit(cache=True, error_model="numpy")
def _summed_quadratic_forms(
    found: tuple[Float, Float, Float], heading: float, prior: Float, known: Float
) -> tuple[Float, Float, Float]:
    """Forms, expected, spread of `FrameQuadraticForms`."""
    rows, seen = _jacobian_gain_and_residual_rows(found, heading, prior)
    n, count, turned = len(rows), len(known), rows.T.copy()
    forms, expected = np.zeros(count), np.zeros((count, count))
    outer, carried = np.zeros((count, 11, 11)), np.zeros((count, n, 11))
    for k in range(count):
        np.dot(known[k], rows, carried[k])
        np.dot(turned, carried[k], outer[k])
        forms[k] = outer[k, 10, 10]
    for j in range(count):
        for k in range(count):
            slope, gain = carried[j, :, :5], carried[k, :, 5:10]
            expected[j, k] = _trace_of_kernel_product(known[j], known[k], seen)
            expected[j, k] -= 2.0 * np.sum(seen * np.sum(slope * gain, axis=1))
            expected[j, k] += np.sum(outer[j, :5, :5] * outer[k, 5:10, 5:10])
    return forms, expected, outer[:, 5:10, 5:10].copy()


@njit(cache=True, error_model="numpy")
def _jacobian_gain_and_residual_rows(
    found: tuple[Float, Float, Float], heading: float, prior: Float
) -> tuple[Float, Float]:
    """Rows (n, 11) of X in body axes, A' and r, all 0 where not seen; and seen (n,), 1 or 0."""
    offset, weight, slope = found
    rows, seen = np.zeros((len(offset), 11)), np.zeros(len(offset))
    c, s = np.cos(heading), np.sin(heading)
    normal = prior.copy()
    for i in range(len(offset)):
        if weight[i] > 0.0 and np.isfinite(offset[i]):
            seen[i], rows[i, 10] = 1.0, offset[i]
            rows[i, 0] = c * slope[i, 0] + s * slope[i, 1]
            rows[i, 1] = c * slope[i, 1] - s * slope[i, 0]
            for a in range(2, 5):
                rows[i, a] = slope[i, a]
            for a in range(5):
                for b in range(5):
                    normal[a, b] += weight[i] * (rows[i, a] * rows[i, b])
    gain = rows[:, :5].copy() @ np.linalg.inv(normal)
    for i in range(len(offset)):
        for a in range(5):
            rows[i, 5 + a] = gain[i, a] * (seen[i] * weight[i])
    return rows, seen


@njit(cache=True, error_model="numpy", fastmath=True)
def _trace_of_kernel_product(one: Float, other: Float, seen: Float) -> float:
    """tr(K_j K_k) over the points seen."""
    total = 0.0
    for i in range(len(seen)):
        row = 0.0
        for j in range(len(seen)):
            row += seen[j] * one[i, j] * other[i, j]
        total += seen[i] * row
    return total


def mean_covariance(frames: Sequence[FrameQuadraticForms]) -> Float:
    """Mean covariance (5, 5) of pose and width in body axes over frames."""
    residue = np.array([one.forms[0] for one in frames])
    kept = [
        one
        for one, r in zip(frames, residue, strict=True)
        if r <= MAX_SQUARED_RESIDUAL_TO_MEDIAN * np.median(residue)
    ]
    forms, expected, spread = (
        np.mean([getattr(one, name) for one in kept], axis=0)
        for name in ("forms", "expected", "spread")
    )
    return np.tensordot(kernel_variance_components(forms, expected), spread, axes=1)


def kernel_variance_components(forms: Float, expected: Float) -> Float:
    """The s_k (K,) px^2, none negative, whose expected forms come nearest to the forms found."""
    scale = np.diag(expected)
    target, matrix = forms / scale, expected / scale[:, None]
    best, least = np.zeros(len(forms)), float(np.sum(target**2))
    for used in product((False, True), repeat=len(forms)):
        if not any(used):
            continue
        found = np.zeros(len(forms))
        found[list(used)] = np.linalg.lstsq(matrix[:, used], target, rcond=None)[0]
        off = float(np.sum((matrix @ found - target) ** 2))
        if found.min() >= 0.0 and off < least:
            best, least = found, off
    return best
