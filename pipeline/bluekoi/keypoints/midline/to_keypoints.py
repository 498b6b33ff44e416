"""Keypoints from the fits of a bending body: pixels, likelihood, covariance."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ...data import BODY_PART_NAMES, Float, Keypoints
from ...study import Robot, Trial
from ..outline.plane import metres_to_body_lengths
from ..outline.to_keypoints import likelihood_factors_at_jumps, likelihood_of_support
from .blobs import BackgroundModel
from .midline_fit import (
    REFERENCE_ARC,
    BendingTemplate,
    bending_basis,
    station_arcs,
    station_positions,
)
from .track import BodyFitHistory, MidlineFit

MIN_STD_PX = 0.03
LENGTH_STD_SHARE = 0.02
"""Standard deviation of the positions of nose and tail tip along the body, as a share of its
length; zero at the reference arc, proportional to the distance from it."""
CORRELATED_STATION_VARIANCE_RATIO = 3.0
"""Ratio of a pose's variance to that for independent stations; errors of neighbouring stations are
correlated. Measured on rendered bodies (tests)."""
TAIL_SUPPORT_RANGE, SEEN_SHARE_RANGE = (0.0, 0.55), (0.4, 0.8)
DOUBTFUL_LIKELIHOOD = 0.5
MIN_FORWARD_MOTION_SHARE = -0.3
MAX_JUMP_LENGTHS, MAX_JUMP_RAD = 0.25, 1.0
BODY_THIRDS_OF_KEYPOINTS = np.array(
    [[1, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 1, 1]], dtype=bool
)


def keypoint_arcs(robot: Robot, trial: Trial) -> Float:
    """Arcs (5,) of the keypoints, nose 0 and tail tip 1, at the shares that study.yaml states."""
    head, com, tail = (
        metres_to_body_lengths(robot, length)
        for length in (trial.head_length_m, robot.hinge_to_com_m, robot.tail_length_m)
    )
    body = total_length(robot, trial) - tail
    return np.array([0.0, head, head + com, body, body + tail]) / (body + tail)


def total_length(robot: Robot, trial: Trial) -> float:
    """Nose to tail tip, body lengths."""
    return metres_to_body_lengths(robot, robot.whole_length_m(trial.head_length_m))


def keypoints_from_fits(
    times: Sequence[float],
    track: BodyFitHistory,
    arena: BackgroundModel,
    shape: BendingTemplate,
    arc: Float,
) -> Keypoints:
    """Keypoints at arcs (5,) of a recording; NaN with likelihood 0 where no body was found.

    The nose is the end that moves ahead; where the body hardly swims, the thicker one.
    """
    n, p = len(times), len(BODY_PART_NAMES)
    xy, likelihood = np.full((n, p, 2), np.nan), np.zeros((n, p))
    cov = np.full((n, p, 2, 2), np.nan)
    known = [(i, one) for i, one in enumerate(track.fits) if one is not None]
    remarks: list[str] = []
    if known:
        where, fits = [i for i, _ in known], [one for _, one in known]
        backwards = _forward_motion_share(fits, shape) < MIN_FORWARD_MOTION_SHARE
        arc = 1 - arc if backwards else arc
        xy[where], cov[where] = _pixels_and_covariances(fits, arena, shape, arc)
        each = np.array([_keypoint_likelihoods(one, backwards=backwards) for one in fits])
        poses = [one.pose if one else None for one in track.fits]
        jumps = likelihood_factors_at_jumps(
            times, poses, MAX_JUMP_LENGTHS * shape.length_bl, MAX_JUMP_RAD
        )
        likelihood[where] = each * jumps[where, None]
    late = np.array(times) >= track.doubtful_s
    doubtful = late | np.isin(np.arange(n), list(track.unsure))
    likelihood[doubtful] = np.minimum(likelihood[doubtful], DOUBTFUL_LIKELIHOOD)
    if late.any():
        remarks.append(
            f"from {track.doubtful_s:.2f} s on the body may be another one: two lay over each "
            "other; split the trial there (start_s, end_s) and give start_x_px, start_y_px"
        )
    if n > len(known):
        first = next(t for t, one in zip(times, track.fits, strict=True) if one is None)
        remarks.append(f"{n - len(known)} of {n} frames without the robot (first at {first:.2f} s)")
    return Keypoints(np.array(times), BODY_PART_NAMES, xy, likelihood, cov, tuple(remarks))


def _forward_motion_share(fits: Sequence[MidlineFit], shape: BendingTemplate) -> float:
    """How far the body moved towards its nose, as a share of its way; 0 where it hardly moved."""
    pose = np.array([one.pose for one in fits])
    step = np.diff(pose[:, :2], axis=0)
    nose = np.column_stack([np.cos(pose[1:, 2]), np.sin(pose[1:, 2])])
    way = float(np.hypot(*step.T).sum())
    return float(np.sum(step * nose)) / way if way > shape.length_bl else 0.0


def _pixels_and_covariances(
    fits: Sequence[MidlineFit], arena: BackgroundModel, shape: BendingTemplate, arc: Float
) -> tuple[Float, Float]:
    """Pixels (n, 5, 2) and covariances (n, 5, 2, 2) of fits."""
    bend, *_ = shape.basis_coverage_and_slopes
    supported = [one.meat for one in fits if one.support[3] > 0.5]
    meat = CORRELATED_STATION_VARIANCE_RATIO * np.mean(
        supported or [one.meat for one in fits], axis=0
    )
    xy, cov = np.empty((len(fits), len(arc), 2)), np.empty((len(fits), len(arc), 2, 2))
    for i, one in enumerate(fits):
        place, slope = _positions_and_pose_jacobians(one, shape, bend, arc)
        xy[i] = arena.plane.body_lengths_to_pixels(place)
        ridge = 1e-3 * np.diag(np.diag(one.information))
        gain = np.linalg.pinv(one.information + ridge)
        step = 0.02 * np.array([[1.0, 0.0], [0.0, 1.0]])
        local = np.stack(
            [
                (
                    arena.plane.body_lengths_to_pixels(place + move)
                    - arena.plane.body_lengths_to_pixels(place - move)
                )
                / 0.04
                for move in step
            ],
            axis=2,
        )
        moved = local @ slope
        heading = one.pose[2] + bending_basis(arc) @ one.pose[3:]
        along = np.column_stack([np.cos(heading), np.sin(heading)])
        along *= (LENGTH_STD_SHARE * shape.length_bl * (arc - REFERENCE_ARC))[:, None]
        stretch = (local @ along[:, :, None])[..., 0]
        cov[i] = moved @ (gain @ meat @ gain) @ moved.swapaxes(1, 2) + MIN_STD_PX**2 * np.eye(2)
        cov[i] += stretch[:, :, None] * stretch[:, None]
    return xy, cov


def _positions_and_pose_jacobians(
    one: MidlineFit, shape: BendingTemplate, bend: Float, arc: Float
) -> tuple[Float, Float]:
    """Places (5, 2) and slopes (5, 2, 3 + BEND_TERMS) of arcs by the pose in body axes."""
    place, _, by_bend = station_positions(one.pose, shape.length_and_half_width, bend)
    at = station_arcs()
    flat = np.concatenate([place, by_bend.reshape(len(at), -1)], axis=1)
    found = np.column_stack([np.interp(arc, at, column) for column in flat.T])
    away = found[:, :2] - one.pose[:2]
    c, s = math.cos(one.pose[2]), math.sin(one.pose[2])
    slope = np.empty((len(arc), 2, 3 + bend.shape[1]))
    slope[:, :, 0], slope[:, :, 1] = (c, s), (-s, c)
    slope[:, 0, 2], slope[:, 1, 2] = -away[:, 1], away[:, 0]
    slope[:, :, 3:] = found[:, 2:].reshape(len(arc), -1, 2).swapaxes(1, 2)
    return found[:, :2], slope


def _keypoint_likelihoods(one: MidlineFit, *, backwards: bool) -> Float:
    """Likelihood (5,) from how much of the picture about each third the body explains."""
    head, core, tail, whole, seen, *visible = one.support
    if backwards:
        head, tail, visible = tail, head, visible[::-1]
    supported = [
        likelihood_of_support(head),
        likelihood_of_support(core),
        likelihood_of_support(tail, TAIL_SUPPORT_RANGE),
    ]
    thirds = np.minimum(supported, [likelihood_of_support(share, SEEN_SHARE_RANGE)
                                    for share in visible])  # fmt: skip
    parts = np.array([thirds[own].min() for own in BODY_THIRDS_OF_KEYPOINTS])
    return likelihood_of_support(whole) * likelihood_of_support(seen, SEEN_SHARE_RANGE) * parts
