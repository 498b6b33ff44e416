"""Weighted least squares of two rigid, hinged parts, all frames at once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri

from ..data import Float
from .rigid_lengths import RigidLengths

GAUSS_NEWTON_ITERATIONS = 6
"""Gauss-Newton steps of a pose, and rounds in which poses and noise are estimated in turn."""
NOISE_ESTIMATION_ROUNDS = 12
OUTLIER_FALSE_ALARM_PROBABILITY = 1e-5
"""Probability with which a right frame is taken for an outlier."""
MIN_STD_M = 1e-6
"""Least standard deviation of a keypoint."""
MIN_OFFSET_SIGMAS, MIN_OFFSET_SHARE = 2.0, 0.005
MIN_FRAMES_FOR_OFFSETS = 20
"""Frames without which no systematic offset of a keypoint is estimated."""


@dataclass(frozen=True)
class PoseFit:
    """state (frames, 4) = x, y, psi, theta; cov (frames, 4, 4); misfit (frames,), chi-squared."""

    state: Float
    cov: Float
    misfit: Float
    residual: Float
    slope: Float


def usable_frames(seen: np.ndarray) -> np.ndarray:
    """Frames (frames,) in which head tip and two points of the core are seen (frames, 4)."""
    return np.asarray(seen[:, 0] & (seen[:, 1:].sum(axis=1) >= 2))


def covariance_with_estimated_noise(xy: Float, cov: Float, body: RigidLengths) -> Float:
    """Covariance with the unknown ones estimated: one variance a part, from the rigid residuals.

    Variance components: s_k^2 = sum of squared residuals over sum of redundancies, repeated
    (Foerstner 1979).
    """
    unknown = np.isfinite(xy[:, :, 0]) & ~np.isfinite(cov).all(axis=(2, 3))
    if not np.any(unknown):
        return cov
    variance = np.full(4, 1e-6)
    filled, state = cov, _starting_state(xy, body)
    for _ in range(NOISE_ESTIMATION_ROUNDS):
        filled = np.where(unknown[:, :, None, None], variance[:, None, None] * np.eye(2), cov)
        fit = fit_rigid_poses(xy, filled, body, state, iterations=2)
        state = np.nan_to_num(fit.state)
        variance = _estimate_part_variances(fit, filled, variance, unknown)
    return filled


def _estimate_part_variances(fit: PoseFit, cov: Float, before: Float, unknown: np.ndarray) -> Float:
    leverage = np.einsum("nkia,nab,nkjb->nkij", fit.slope, fit.cov, fit.slope)
    used = np.isfinite(fit.residual).all(axis=2) & unknown
    typical = np.nanmedian(fit.misfit[fit.misfit > 0]) if np.any(fit.misfit > 0) else 0.0
    used &= (fit.misfit < 10 * typical)[:, None]
    variance = before.copy()
    for k in range(4):
        squares = np.sum(fit.residual[used[:, k], k] ** 2)
        weight = np.linalg.inv(cov[used[:, k], k])
        free = 2 - np.einsum("nij,nji->n", leverage[used[:, k], k], weight)
        redundancy = np.sum(np.clip(free, 0, None))
        if redundancy > 1:
            variance[k] = max(squares / redundancy, MIN_STD_M**2)
    return variance


def fit_rigid_poses(
    xy: Float,
    cov: Float,
    body: RigidLengths,
    start: Float | None = None,
    *,
    iterations: int = GAUSS_NEWTON_ITERATIONS,
) -> PoseFit:
    """Pose of every frame by Gauss-Newton, from `start` (frames, 4) where one is known.

    xy (frames, 4, 2) m, NaN where not seen; cov (frames, 4, 2, 2).
    """
    seen = np.isfinite(xy[:, :, 0])
    usable = usable_frames(seen)
    weight = np.zeros_like(cov)
    weight[seen] = np.linalg.inv(cov[seen])
    state = _starting_state(xy, body) if start is None else start
    points = np.where(seen[:, :, None], xy, 0.0)
    for _ in range(iterations):
        model, slope = _modelled_points(state, body)
        residual = np.where(seen[:, :, None], points - model, 0.0)
        rhs = np.einsum("nkia,nkij,nkj->na", slope, weight, residual)
        normal = np.einsum("nkia,nkij,nkjb->nab", slope, weight, slope)
        normal[~usable] = np.eye(4)
        state = state + np.linalg.solve(normal, rhs[:, :, None])[:, :, 0]
    model, slope = _modelled_points(state, body)
    residual = np.where(seen[:, :, None], points - model, 0.0)
    misfit = np.einsum("nki,nkij,nkj->n", residual, weight, residual)
    cov_state = np.linalg.inv(normal)
    state[~usable], cov_state[~usable], misfit[~usable] = np.nan, np.nan, np.nan
    residual = np.where((seen & usable[:, None])[:, :, None], residual, np.nan)
    return PoseFit(state, cov_state, misfit, residual, slope)


def _starting_state(xy: Float, body: RigidLengths) -> Float:
    """Core axis through its outermost points, head from the hinge that follows from it."""
    along = np.array([body.hinge_m, 0.0, -body.tail_m])
    front = np.argmax(np.isfinite(xy[:, 1:, 0]), axis=1)
    rear = 2 - np.argmax(np.isfinite(xy[:, :0:-1, 0]), axis=1)
    rows = np.arange(len(xy))
    way = xy[rows, 1 + front] - xy[rows, 1 + rear]
    psi = np.arctan2(way[:, 1], way[:, 0])
    axis = np.column_stack([np.cos(psi), np.sin(psi)])
    center = xy[rows, 1 + rear] - axis * along[rear][:, None]
    ahead = xy[:, 0] - (center + axis * body.hinge_m)
    theta = np.arctan2(ahead[:, 1], ahead[:, 0])
    return np.nan_to_num(np.column_stack([center, psi, theta]))


def _modelled_points(state: Float, body: RigidLengths) -> tuple[Float, Float]:
    """Points (frames, 4, 2) of a pose and their derivative (frames, 4, 2, 4)."""
    core = np.column_stack([np.cos(state[:, 2]), np.sin(state[:, 2])])
    head = np.column_stack([np.cos(state[:, 3]), np.sin(state[:, 3])])
    along = np.array([body.hinge_m, body.hinge_m, 0.0, -body.tail_m])
    ahead = np.array([body.head_m, 0.0, 0.0, 0.0])
    from_center = np.column_stack([along, np.zeros(4)])
    from_hinge = np.column_stack([ahead, np.zeros(4)])
    from_hinge[0] += body.offset_m[0]
    from_center[1:] += body.offset_m[1:]
    on_core, on_head = (
        _points_in_pool_frame(from_center, core),
        _points_in_pool_frame(from_hinge, head),
    )
    slope = np.zeros((len(state), 4, 2, 4))
    slope[:, :, 0, 0] = slope[:, :, 1, 1] = 1
    turned = np.array([[0.0, 1.0], [-1.0, 0.0]])  # d/da of (cos a, sin a), rows times this
    slope[:, :, :, 2] = on_core @ turned
    slope[:, :, :, 3] = on_head @ turned
    return state[:, None, :2] + on_core + on_head, slope


def _points_in_pool_frame(own: Float, axis: Float) -> Float:
    """Points (frames, 4, 2) in the pool from those (4, 2) along and left of axes (frames, 2)."""
    left = np.column_stack([-axis[:, 1], axis[:, 0]])
    return own[:, :1] * axis[:, None] + own[:, 1:] * left[:, None]


def systematic_keypoint_offsets(xy: Float, body: RigidLengths) -> Float:
    """Systematic offset of each point (4, 2), along and to the left of its part, m.

    Median residual of the rigid body over all frames, all points of one weight; zero unless one of
    them exceeds `MIN_OFFSET_SIGMAS` times its std and `MIN_OFFSET_SHARE` of the body. Without
    it, a point would be left out of some frames only and bend the pose there.
    """
    fit = fit_rigid_poses(xy, np.broadcast_to(np.eye(2), (*xy.shape, 2)), body)
    toward = np.column_stack([fit.state[:, 3], *[fit.state[:, 2]] * 3])
    cos, sin = np.cos(toward), np.sin(toward)
    x, y = fit.residual[:, :, 0], fit.residual[:, :, 1]
    own = np.stack([cos * x + sin * y, cos * y - sin * x], axis=2)
    seen = np.isfinite(own).all(axis=(1, 2))
    if seen.sum() < MIN_FRAMES_FOR_OFFSETS:
        return np.zeros((4, 2))
    offset = np.median(own[seen], axis=0)
    spread = 1.48 * np.median(np.abs(own[seen] - offset), axis=0)
    least = MIN_OFFSET_SHARE * (body.hinge_m + body.tail_m)
    steady = (np.abs(offset) > MIN_OFFSET_SIGMAS * spread) & (np.abs(offset) > least)
    return offset if steady.any() else np.zeros((4, 2))


def robust_pose_fit(xy: Float, cov: Float, body: RigidLengths) -> tuple[PoseFit, int]:
    """The fit without a frame's worst point where the others agree; else with a larger cov."""
    fit = fit_rigid_poses(xy, cov, body)
    bad = _exceeds_misfit_limit(fit.misfit, xy)
    if not np.any(bad):
        return fit, 0
    trials = []
    for k in range(4):
        fewer = xy.copy()
        fewer[bad, k] = np.nan
        again = fit_rigid_poses(fewer, cov, body)
        free = np.maximum(degrees_of_freedom(fewer), 1)
        trials.append(np.where(np.isfinite(again.misfit), again.misfit / free, np.inf))
    worst = np.argmin(trials, axis=0)
    cleaned = xy.copy()
    repaired = bad & np.isfinite(np.min(trials, axis=0))
    cleaned[repaired, worst[repaired]] = np.nan
    fit = fit_rigid_poses(cleaned, cov, body)
    scale = np.where(
        _exceeds_misfit_limit(fit.misfit, cleaned),
        fit.misfit / np.maximum(degrees_of_freedom(cleaned), 1),
        1,
    )
    return replace(fit, cov=fit.cov * scale[:, None, None]), int(repaired.sum())


def degrees_of_freedom(xy: Float) -> Float:
    """Coordinates less unknowns of each frame's pose, (frames,), for points (frames, 4, 2)."""
    return 2.0 * np.isfinite(xy[:, :, 0]).sum(axis=1) - 4


def _exceeds_misfit_limit(misfit: Float, xy: Float) -> np.ndarray:
    free = degrees_of_freedom(xy)
    limit = chdtri(np.maximum(free, 1), OUTLIER_FALSE_ALARM_PROBABILITY)
    return (free > 0) & (np.nan_to_num(misfit) > limit)
