"""Fits of all frames as keypoints: pixels, likelihood, covariance."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...data import BODY_PART_NAMES, Float, Keypoints
from .outline_fit_covariance import mean_covariance
from .template import OutlineTemplate
from .tracking import DetectionScene, OutlineFit

FULL_SUPPORT, MIN_SUPPORT = 0.80, 0.35
HEAD_EDGE_SUPPORT_RANGE = (0.25, 0.55)
HEAD_ANGLE_TOLERANCE_RAD = 0.07
MIN_STD_PX = 0.005
DERIVATIVE_STEP_BL = 0.03
MAX_JUMP_BL, MAX_JUMP_RAD = 0.06, 0.5
MIN_TAIL_TIP_STD_PER_TAIL_LENGTH = (0.0041, 0.0036)
MIN_WIDTH_RATIO, MIN_CONTRAST_RATIO = 0.25, 0.14
TIP_ERROR_ALONG_SHARES, TIP_ERROR_ACROSS_SHARES = (0.06, 0.4), (0.24, 0.7)
"""Standard deviation of the tail tip along the tail and across it: at least a share of the tail's
length; per paleness times that length; per width beyond the usual one. Measured against rendered
footage."""


def keypoints_from_fits(
    times: Sequence[float],
    fits: Sequence[OutlineFit | None],
    scene: DetectionScene,
    template: OutlineTemplate,
    remarks: tuple[str, ...],
) -> Keypoints:
    """Keypoints of a recording; NaN with likelihood 0 where the robot was not found.

    Where the head fits badly in most frames its shape was not learned, and no point along the
    body is believed.
    """
    n, p = len(times), len(BODY_PART_NAMES)
    xy, likelihood = np.full((n, p, 2), np.nan), np.zeros((n, p))
    cov = np.full((n, p, 2, 2), np.nan)
    where = [i for i, one in enumerate(fits) if one is not None]
    known = [one for one in fits if one is not None]
    if known:
        xy[where], cov[where] = _pixels_and_covariances(known, scene, template)
        bend = float(np.median([one.pose[3] for one in known]))
        poses = [one.pose if one else None for one in fits]
        jumps = likelihood_factors_at_jumps(times, poses, MAX_JUMP_BL, MAX_JUMP_RAD)
        head = float(np.median([one.support[0] for one in known]))
        known_shape = likelihood_of_support(head, HEAD_EDGE_SUPPORT_RANGE)
        each = np.array([_keypoint_likelihoods(one, bend) for one in known])
        likelihood[where] = known_shape * jumps[where, None] * each
    likelihood[~np.isfinite(xy).all(axis=2)] = 0.0
    return Keypoints(
        np.array(times), BODY_PART_NAMES, xy, likelihood, cov, remarks, _seen_length_ratios(fits)
    )


def _seen_length_ratios(fits: Sequence[OutlineFit | None]) -> Float:
    """Whole length (frames,) seen over stated, where the outline was found; else NaN.

    The tail's own support is not asked: it is less where the tail is shorter than stated.
    """
    return np.array([one.length if one is not None and one.support[2] > FULL_SUPPORT else math.nan
                     for one in fits])  # fmt: skip


def _median_nose_offset_px(fits: Sequence[OutlineFit]) -> float:
    """Median distance [px] of the nose's edge ahead of the template's, over the whole recording.

    The template's nose is known from a few frames only; all of them place the outline better.
    """
    seen = [
        one.nose_px for one in fits if math.isfinite(one.nose_px) and one.support[0] > FULL_SUPPORT
    ]
    return float(np.median(seen)) if len(seen) > 4 else 0.0


def _pixels_and_covariances(
    fits: Sequence[OutlineFit], scene: DetectionScene, template: OutlineTemplate
) -> tuple[Float, Float]:
    """Pixels (n, 5, 2) and covariances (n, 5, 2, 2) of fits."""
    pose = np.array([one.pose for one in fits])
    hinge, core = pose[:, 0] + 1j * pose[:, 1], np.exp(1j * pose[:, 2])
    hinge += _median_nose_offset_px(fits) / scene.plane.px_per_bl * np.cos(pose[:, 3]) * core
    arms = np.zeros((len(fits), 4), dtype=complex)
    arms[:, 0] = template.head_bl * np.exp(-1j * pose[:, 3])
    arms[:, 2:] = [-template.com_bl, -template.core_bl]
    places = hinge[:, None] + arms * core[:, None]
    uv = _plane_points_to_pixels(scene, places)
    slope = _core_axes_to_pixel_jacobians(scene, hinge, core)
    moves = np.zeros((len(fits), 4, 2, 4))
    moves[..., 0, 0] = moves[..., 1, 1] = 1.0
    moves[..., 0, 2], moves[..., 1, 2] = -arms.imag, arms.real
    moves[:, 0, :, 3] = -moves[:, 0, :, 2]
    carried = slope[:, None] @ moves
    inner = _pose_covariances(fits)[:, None]
    cov = carried @ inner @ carried.swapaxes(2, 3) + MIN_STD_PX**2 * np.eye(2)
    tips = np.array([one.tail[0] for one in fits])
    tails = _tail_covariances(fits, cov[:, 3], template.tail_bl * scene.plane.px_per_bl)
    return np.concatenate([uv, tips[:, None]], axis=1), np.concatenate(
        [cov, tails[:, None]], axis=1
    )


def _plane_points_to_pixels(scene: DetectionScene, places: npt.NDArray[np.complex128]) -> Float:
    """Pixels (..., 2) of places x + i y in the plane."""
    flat = np.column_stack([places.real.ravel(), places.imag.ravel()])
    return scene.plane.body_lengths_to_pixels(flat).reshape(*places.shape, 2)


def _core_axes_to_pixel_jacobians(
    scene: DetectionScene, places: npt.NDArray[np.complex128], core: npt.NDArray[np.complex128]
) -> Float:
    """Change of the pixel (u, v) with a shift along and across the core at places (n,), px per body
    length, (n, 2, 2).
    """
    step = DERIVATIVE_STEP_BL * core[:, None] * np.array([1.0, 1j])
    ahead, behind = (
        _plane_points_to_pixels(scene, places[:, None] + sign * step) for sign in (1, -1)
    )
    return ((ahead - behind) / (2 * DERIVATIVE_STEP_BL)).swapaxes(1, 2)


def _pose_covariances(fits: Sequence[OutlineFit]) -> Float:
    """Covariances (n, 4, 4): the usual one, wider where less of the outline was seen."""
    middle = np.median([one.information for one in fits], axis=0)
    known = [one.statistics for one in fits if one.statistics is not None]
    usual = mean_covariance(known) if known else np.linalg.inv(middle)
    ridge = 1e-3 * np.diag(np.diag(middle))
    widened = np.linalg.solve(np.array([one.information for one in fits]) + ridge, middle + ridge)
    return (widened @ usual @ widened.swapaxes(1, 2))[:, :4, :4]


def _tail_covariances(fits: Sequence[OutlineFit], bases: Float, length_px: float) -> Float:
    """Covariances (n, 2, 2) of the tail tip: the base's, and what the tail's own signs show.

    A tail that is pale towards its end moved during the exposure; one wider than it usually is
    has a shadow or a shine beside it; either may have displaced the trace.
    """
    heading = np.array([one.tail[1] for one in fits])
    scatter, pale, width = np.array([one.tail[3] for one in fits]).T
    slim = np.nanquantile(width, MIN_WIDTH_RATIO) if np.isfinite(width).any() else 0.0
    signs = np.maximum([length_px * (pale - MIN_CONTRAST_RATIO), width - slim], 0.0)
    least = length_px * np.array(MIN_TAIL_TIP_STD_PER_TAIL_LENGTH)
    along = least[0] ** 2 + np.array(TIP_ERROR_ALONG_SHARES) ** 2 @ signs**2
    across = np.maximum(scatter, least[1]) ** 2 + np.array(TIP_ERROR_ACROSS_SHARES) ** 2 @ signs**2
    axis = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    side = np.stack([-axis[:, 1], axis[:, 0]], axis=1)
    outer = [v[:, :, None] * v[:, None] for v in (axis, side)]
    return bases + along[:, None, None] * outer[0] + across[:, None, None] * outer[1]


def _keypoint_likelihoods(one: OutlineFit, bend: float) -> Float:
    """Likelihood (5,) from how much of the outline about each part is where it should be.

    The core alone tapers, so that without the head it may have slid along itself.
    """
    head, core, both = (likelihood_of_support(value) for value in one.support)
    core = min(core, both)
    off = math.remainder(one.pose[3] - bend, 2 * math.pi) / HEAD_ANGLE_TOLERANCE_RAD
    sane = math.exp(-0.5 * max(0.0, abs(off) - 1.0) ** 2)
    tail = min(core, likelihood_of_support(one.tail[2]))
    return sane * np.array([head, min(head, core), core, core, tail])


def likelihood_of_support(
    support: float, between: tuple[float, float] = (MIN_SUPPORT, FULL_SUPPORT)
) -> float:
    """Likelihood 0 to 1 of a support between two levels."""
    return min(max((support - between[0]) / (between[1] - between[0]), 0.0), 1.0)


def likelihood_factors_at_jumps(
    times: Sequence[float], poses: Sequence[Float | None], max_move: float, max_turn: float
) -> Float:
    """Factor (frames,) that falls where a body jumps both to and from a frame.

    A lone pose (x, y, heading, ...) that lies off the line between its neighbours by more than a
    body can accelerate.
    """
    factor = np.ones(len(poses))
    for i in range(1, len(poses) - 1):
        before, here, after = poses[i - 1], poses[i], poses[i + 1]
        if before is None or here is None or after is None:
            continue
        share = (times[i] - times[i - 1]) / (times[i + 1] - times[i - 1])
        off = here - before - share * (after - before)
        turned = abs(math.remainder(off[2], 2 * math.pi))
        factor[i] = 0.2 if math.hypot(off[0], off[1]) > max_move or turned > max_turn else 1.0
    return factor
