"""Errors of a fit, estimated from its residuals: the variances and covariance put in."""

from __future__ import annotations

import numpy as np
import pytest

from bluekoi.keypoints.outline.outline_fit_covariance import (
    covariance_kernels,
    frame_quadratic_forms,
    kernel_variance_components,
    mean_covariance,
)

LENGTH_M = 0.33
PRIOR_PRECISION = np.array([3e3, 3e3, 30.0, 30.0, 1.0])
PX_PER_M = 620.0


def drop_outline() -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 2) m and outward normals (n, 2) of a drop, pointed behind, about its middle."""
    angle = np.linspace(0, 2 * np.pi, 90, endpoint=False)
    x, y = np.cos(angle), 0.2 * np.sin(angle) * (1.3 + np.cos(angle))
    points = 0.5 * LENGTH_M * np.column_stack([x, y])
    step = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    normals = np.column_stack([step[:, 1], -step[:, 0]])
    return points, normals / np.hypot(*normals.T)[:, None]


def offset_derivatives() -> np.ndarray:
    """Derivatives (n, 5) of the offsets, px, by pose (the head being all that lies in front)."""
    (x, y), (nx, ny) = (a.T for a in drop_outline())
    turn = PX_PER_M * (nx * -y + ny * x)
    front = np.where(x > 0, -turn, 0.0)
    return np.column_stack([PX_PER_M * nx, PX_PER_M * ny, turn, front, np.ones(len(x))])


def simulated_frames(variance: tuple[float, ...], rng: np.random.Generator, count: int):
    """Clues of frames whose offsets have these variances, and the pose errors (count, 5)."""
    points, normals = drop_outline()
    known, slope = covariance_kernels(points, normals, LENGTH_M), offset_derivatives()
    root = np.linalg.cholesky(np.tensordot(variance, known, axes=1) + 1e-9 * np.eye(len(points)))
    reported, errors = [], []
    for _ in range(count):
        weight = np.where(rng.random(len(points)) < 0.1, 0.0, rng.uniform(0.6, 1.0, len(points)))
        e = root @ rng.standard_normal(len(points))
        normal = slope.T @ (weight[:, None] * slope) + np.diag(PRIOR_PRECISION)
        change = np.linalg.solve(normal, slope.T @ (weight * e))
        errors.append(change)
        left = np.where(weight > 0, e - slope @ change, np.nan)
        reported.append(frame_quadratic_forms((left, weight, slope), 0.0, PRIOR_PRECISION, known))
    return reported, np.array(errors)


@pytest.mark.parametrize("variance", [(0.04, 0.0, 0.0), (0.01, 0.01, 0.01), (0.02, 0.1, 0.05)])
def test_variances_and_covariance_are_those_put_in(variance):
    reported, errors = simulated_frames(variance, np.random.default_rng(5), 300)
    forms, expected = (
        np.mean([getattr(t, n) for t in reported], axis=0) for n in ("forms", "expected")
    )
    assert kernel_variance_components(forms, expected) == pytest.approx(
        variance, abs=0.12 * sum(variance)
    )
    stated = mean_covariance(reported)
    pulls = np.sqrt(np.mean(errors**2, axis=0) / np.diag(stated))
    assert np.all((pulls > 0.85) & (pulls < 1.15))


def test_the_algebra_is_that_of_whole_matrices():
    points, normals = drop_outline()
    known, slope = covariance_kernels(points, normals, LENGTH_M), offset_derivatives()
    rng = np.random.default_rng(1)
    seen = rng.random(len(points)) > 0.2
    weight, left = np.where(seen, 0.7, 0.0), np.where(seen, rng.normal(0, 0.1, len(points)), np.nan)
    reported = frame_quadratic_forms((left, weight, slope), 0.4, PRIOR_PRECISION, known)
    c, s = np.cos(0.4), np.sin(0.4)
    body = slope.copy()
    body[:, 0], body[:, 1] = c * slope[:, 0] + s * slope[:, 1], c * slope[:, 1] - s * slope[:, 0]
    x = np.where(seen[:, None], body, 0.0)
    gain = np.linalg.solve(x.T @ (weight[:, None] * x) + np.diag(PRIOR_PRECISION), x.T * weight)
    rest, r = np.diag(seen.astype(float)) - x @ gain, np.nan_to_num(left)
    assert reported.forms == pytest.approx([r @ k @ r for k in known])
    for j, one in enumerate(known):
        right = [np.trace(one @ rest @ other @ rest.T) for other in known]
        assert reported.expected[j] == pytest.approx(right)
        assert reported.spread[j] == pytest.approx(gain @ one @ gain.T)


def test_no_variance_is_negative():
    expected = np.array([[100.0, 90, 80], [90, 500, 600], [80, 600, 2000]])
    found = kernel_variance_components(expected @ np.array([1.0, -0.3, 0.1]), expected)
    assert np.all(found >= 0)
    assert found.sum() > 0
    assert len(found) == 3
