"""Pose of the robot's two rigid parts, frame by frame, from keypoints in the pool frame.

Core: hinge, core_center and tail_base lie on one axis. Head: head_tip and hinge. With u(a) =
(cos a, sin a), c the centre of mass, psi the core's and theta the head's direction,
    hinge = c + a u(psi), core_center = c, tail_base = c - b u(psi), head_tip = hinge + h u(theta).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data import Float, KeypointPositions, Pose, has_excess_variance
from ..errors import input_error
from ..study import Robot
from .fit import (
    PoseFit,
    covariance_with_estimated_noise,
    robust_pose_fit,
    systematic_keypoint_offsets,
    usable_frames,
)
from .rigid_lengths import RIGID_PARTS, RigidLengths, measured_rigid_lengths, trusted_points

LENGTH_TOLERANCE = 0.02
"""Relative error of a rigid length above which the pose carries a remark."""
MIN_REPORTED_GAP_S = 1.0
"""Gap in the keypoints above which the track carries a remark."""
UNWRAP_WINDOW_FRAMES = 9
"""Frames in the moving average of the direction; fewer where they span half a turn."""
GAP_STEPS, MIN_STRETCH_SHARE = 1.5, 0.5
"""A step of so many median ones is a gap; a stretch beside it must be this part as long."""
MAX_DIRECTION_STD_RAD = 0.5
"""A direction with a larger std does not count turns, however long it lasts: half a second of
exchanged labels, with a std of 4 rad, wound the heading by a whole turn.
"""

__all__ = ["RigidLengths", "measured_rigid_lengths", "rigid_pose", "unwrapped_angles"]


def rigid_pose(positions: KeypointPositions, robot: Robot, head_length_m: float) -> Pose:
    """Pose [x, y of the centre of mass, core heading unwrapped, head angle] with cov, per frame.

    Weighted least squares on the points that count (`is_confident`); the head angle is core
    minus head, wrapped to (-pi, pi]. Distances between the parts are this trial's own medians, so
    that an error of scale does not bend the pose; the robot's lengths replace those of parts never
    seen together. Where the points have no covariance it is estimated from the residuals of the
    rigid body. A frame whose residual is larger than chance (1 in 100 000) loses its worst point.
    NaN where head_tip or two of the core's three points are not seen. cov (frames, 4, 4) is
    independent from frame to frame. Points with a systematic offset stay in every frame
    (`systematic_keypoint_offsets`).

    Raises: InputError where no frame has enough points.
    """
    xy, cov = trusted_points(positions)
    usable = usable_frames(np.isfinite(xy[:, :, 0]))
    if not np.any(usable):
        raise _no_usable_keypoints_error(positions, xy)
    body = measured_rigid_lengths(xy, np.zeros_like(cov), robot, head_length_m)
    offset = systematic_keypoint_offsets(xy, body)
    cov = covariance_with_estimated_noise(xy, cov, replace(body, offset_m=offset))
    body = replace(measured_rigid_lengths(xy, cov, robot, head_length_m), offset_m=offset)
    fit, dropped = robust_pose_fit(xy, cov, body)
    values, spread = _pose_from_fit(fit, positions.time_s)
    remarks = (
        *positions.remarks,
        *_length_remarks(body, robot, head_length_m),
        *_offset_remarks(body),
        *_missing_frames_and_gap_remarks(positions.time_s, np.isfinite(values[:, 0]), dropped),
    )
    return Pose(positions.time_s, values, spread, remarks)


def _pose_from_fit(fit: PoseFit, time_s: Float) -> tuple[Float, Float]:
    change = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, -1]])
    values = fit.state @ change.T
    cov = change @ fit.cov @ change.T
    values[:, 2] = unwrapped_angles(values[:, 2], cov[:, 2, 2], time_s)
    values[:, 3] = _wrap_to_half_turn(values[:, 3])
    return values, cov


def unwrapped_angles(angle: Float, variance: Float, time_s: Float | None = None) -> Float:
    """Angles (frames,) [rad] without jumps of whole turns; NaN where not seen.

    Each is placed next to the mean direction of the frames around it, without single uncertain
    ones: a frame with head and tail exchanged must not start a turn that later frames continue.
    time_s (frames,): where the frames are not evenly spaced.
    """
    times = np.arange(len(angle), dtype=float) if time_s is None else time_s
    known = np.flatnonzero(np.isfinite(angle))
    if len(known) == 0:
        return angle
    poor = has_excess_variance(variance[known], np.nanmedian(variance[known]))
    unknown = variance[known] > max(MAX_DIRECTION_STD_RAD**2, float(np.nanmedian(variance[known])))
    well = known[~(_in_short_runs(poor) | _in_short_runs(unknown, len(unknown)))]
    step = np.median(np.abs(np.diff(np.unwrap(angle[well])))) if len(well) > 1 else 0.0
    window = int(np.clip(np.pi / max(step, 1e-9), 1, min(UNWRAP_WINDOW_FRAMES, len(well))))
    mean = np.convolve(np.exp(1j * angle[well]), np.ones(window), mode="same")
    near = np.interp(times, times[well], _unwrapped_mean(np.angle(mean), times[well]))
    return angle + 2 * np.pi * np.round((near - angle) / (2 * np.pi))


def _unwrapped_mean(angle: Float, times: Float) -> Float:
    """Directions (n,) unwrapped.

    Over a gap the rate is the mean of stretches as long as the gap before and after it, which
    averages the tail beat; where the two give different turns, the smaller one.
    """
    if len(angle) < 2:
        return angle
    step, span = _wrap_to_half_turn(np.diff(angle)), np.diff(times)
    gaps = np.flatnonzero(span > GAP_STEPS * np.median(span))
    for k, later in zip(gaps, [*gaps, len(step)][1:], strict=True):
        before = slice(int(np.searchsorted(times[: k + 1], times[k] - span[k])), k)
        after = slice(k + 1, min(later, int(np.searchsorted(times, times[k + 1] + span[k]))))
        turns = [_wrap_to_half_turn(step[k] - on) + on for on in (
            step[s].sum() * span[k] / span[s].sum()
            for s in (before, after) if span[s].sum() > MIN_STRETCH_SHARE * span[k])]  # fmt: skip
        if turns:
            step[k] = turns[0] if np.ptp(turns) < 1.0 else min(turns, key=abs)
    return angle[0] + np.concatenate([[0.0], np.cumsum(step)])


def _wrap_to_half_turn(angle: Float) -> Float:
    return -((np.pi - angle) % (2 * np.pi) - np.pi)


def _in_short_runs(marked: np.ndarray, max_length: int = UNWRAP_WINDOW_FRAMES) -> np.ndarray:
    """Which marked frames (n,) stand in runs of `max_length` at most, between good frames: nothing
    else shows how far the heading has turned over a longer run or before the first good frame.
    """
    ends = np.flatnonzero(np.diff(np.concatenate([[0], marked.astype(int), [0]])))
    out = np.zeros(len(marked), dtype=bool)
    for first, last in ends.reshape(-1, 2):
        out[first:last] = first > 0 and last < len(marked) and last - first <= max_length
    return out


def _length_remarks(body: RigidLengths, robot: Robot, head_length_m: float) -> tuple[str, ...]:
    pairs = {
        "hinge to core_center": (body.hinge_m, robot.hinge_to_com_m),
        "core_center to tail_base": (body.tail_m, robot.com_to_tail_base_m),
        "hinge to head_tip": (body.head_m, head_length_m),
    }
    return tuple(
        f"{name} measures {1000 * found:.1f} mm in the pool, study.yaml or trials.csv say "
        f"{1000 * known:.1f} mm"
        for name, (found, known) in pairs.items()
        if abs(found - known) > LENGTH_TOLERANCE * known
    )


def _offset_remarks(body: RigidLengths) -> tuple[str, ...]:
    """A remark on the point with the largest systematic offset."""
    off = np.linalg.norm(body.offset_m, axis=1)
    if not off.any():
        return ()
    return (
        "pose: keypoints are systematically off the rigid body, "
        f"{RIGID_PARTS[int(np.argmax(off))]} by {1000 * off.max():.1f} mm: "
        "one of them is marked in the wrong place",
    )


def _missing_frames_and_gap_remarks(
    time_s: Float, known: np.ndarray, dropped: int
) -> tuple[str, ...]:
    remarks = []
    if not np.all(known):
        remarks.append(f"pose: {int((~known).sum())} of {len(known)} frames lack keypoints")
    if dropped:
        remarks.append(f"pose: one keypoint left out in {dropped} frames, off the rigid body")
    gap = np.max(np.diff(time_s[known]), initial=0.0)
    if gap > MIN_REPORTED_GAP_S:
        remarks.append(f"pose: a gap of {gap:.1f} s; whole turns in it would not be noticed")
    return tuple(remarks)


def _no_usable_keypoints_error(positions: KeypointPositions, xy: Float) -> Exception:
    counts = np.isfinite(xy[:, :, 0]).sum(axis=0)
    seen = ", ".join(f"{name} in {n}" for name, n in zip(RIGID_PARTS, counts, strict=True))
    return input_error(
        "keypoints",
        "",
        f"{seen} of {len(positions.time_s)} frames, never enough",
        "frames with head_tip and two of hinge, core_center, tail_base",
        "In a film: is head_angle_deg of the right sign (positive where the head points to the "
        "robot's right), and is the robot whole, apart from the floor in brightness, and alone in "
        "view? In a keypoint file: map other names under `bodyparts:` in study.yaml.",
    )
