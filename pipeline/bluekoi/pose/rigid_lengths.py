"""Rigid distances of one trial, from its own keypoints."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..data import Float, KeypointPositions, is_confident
from ..study import Robot

RIGID_PARTS = ("head_tip", "hinge", "core_center", "tail_base")
"""Keypoints on the rigid head and core, in the order of all arrays."""


@dataclass(frozen=True)
class RigidLengths:
    """Distances of one trial, m: hinge and tail base from centre of mass, head tip from hinge.

    offset_m: (4, 2), systematic offset of each of RIGID_PARTS, along and to the left of the head
    (head tip) or of the core (the others).
    """

    hinge_m: float
    tail_m: float
    head_m: float
    offset_m: Float = field(default_factory=lambda: np.zeros((len(RIGID_PARTS), 2)))


def measured_rigid_lengths(
    xy_m: Float, cov_m2: Float, robot: Robot, head_length_m: float
) -> RigidLengths:
    """Median distances of one trial, the share that noise adds across the axis (s^2 / 2d) removed.

    xy_m: (frames, 4, 2) of RIGID_PARTS; cov_m2: (frames, 4, 2, 2). Where the centre of mass is
    never seen with a neighbour, hinge to tail base is divided as the robot's own lengths are.
    """
    hinge = _median_distance(xy_m, cov_m2, 1, 2)
    tail = _median_distance(xy_m, cov_m2, 2, 3)
    whole = _median_distance(xy_m, cov_m2, 1, 3)
    head = _median_distance(xy_m, cov_m2, 0, 1)
    known = (robot.hinge_to_com_m, robot.com_to_tail_base_m)
    seen = ((whole, sum(known)), (hinge, known[0]), (tail, known[1]), (head, head_length_m))
    scale = _first_finite(*(length / stated for length, stated in seen if stated > 0), 1)
    return RigidLengths(
        hinge_m=_first_finite(hinge, whole - tail, scale * known[0]),
        tail_m=_first_finite(tail, whole - hinge, scale * known[1]),
        head_m=_first_finite(head, scale * head_length_m),
    )


def trusted_points(positions: KeypointPositions) -> tuple[Float, Float]:
    """Points (frames, 4, 2) of the rigid parts, NaN where not trusted, and their covariance."""
    n = len(positions.time_s)
    xy, cov = np.full((n, 4, 2), np.nan), np.full((n, 4, 2, 2), np.nan)
    for i, name in enumerate(RIGID_PARTS):
        if name in positions.names:
            k = positions.names.index(name)
            trusted = is_confident(positions.likelihood[:, k])
            xy[trusted, i] = positions.xy_m[trusted, k]
            cov[trusted, i] = positions.cov_m2[trusted, k]
    xy[~np.isfinite(xy).all(axis=2)] = np.nan
    return xy, cov


def _median_distance(xy: Float, cov: Float, i: int, j: int) -> float:
    way = xy[:, i] - xy[:, j]
    length = np.linalg.norm(way, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        across = np.column_stack([-way[:, 1], way[:, 0]]) / length[:, None]
        spread = np.einsum("ni,nij,nj->n", across, cov[:, i] + cov[:, j], across)
        length = length - np.nan_to_num(spread) / (2 * length)
    return float(np.nanmedian(length)) if np.any(np.isfinite(length)) else float("nan")


def _first_finite(*candidates: float) -> float:
    return next(value for value in candidates if np.isfinite(value))
