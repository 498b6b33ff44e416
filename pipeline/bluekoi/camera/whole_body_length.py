"""Whole length of the body, nose to tail: the scale where keypoints lie at stated lengths."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data import Float, KeypointPositions, is_confident
from ..errors import input_error
from ..study import Robot
from .rigid_distances import (
    STATED_LENGTH_STD_SHARE,
    CameraGeometry,
    RigidDistances,
    pixels_of_places,
    robust_std_and_inliers,
)

WHOLE_LENGTH_LABEL = "whole length"
"""`measured` in geometry.json, where it replaces the rigid distances."""
WHOLE_LENGTH_END_PARTS = ("head_tip", "tail_tip")
"""Parts between which the whole length is measured."""
REQUIRED_CONFIDENT_PARTS = ("head_tip", "hinge", "core_center")
"""Parts whose likelihood decides whether a frame is used. Not the tail: its likelihood is lower
where the tail is shorter than stated.
"""
WHOLE_LENGTH_PAIR_NUMBER = 3.0
"""Number of this pair, after those of `RIGID_PAIRS`; no keypoint bias changes its length."""
BODY_END_ERROR_PX, MOTION_BLUR_ERROR_SHARE = 0.5, 0.8
"""Systematic error of an end, px, and as a share of the frames' spread by motion blur
(docs/measuring.md).
"""
TRIAL_TO_TRIAL_LENGTH_STD_SHARE = 0.003
"""Relative error common to all frames of a trial."""
MIN_SHARP_TRIALS = 3
MAX_LENGTH_STD_SHARE = 0.006
"""Relative spread of the length over the frames; with more, the exposure was so long that the
tail has no visible end.
"""
MIN_SHARP_FRAMES_PER_TRIAL = 10
"""Frames in which both ends of the body must be seen sharply for a trial to measure its length."""


def whole_body_lengths(
    trials: Sequence[KeypointPositions],
    seen: Sequence[Float],
    head_lengths_m: Sequence[float],
    robot: Robot,
) -> RigidDistances:
    """Whole lengths of all trials against the stated ones.

    seen: of each trial (n, 2) frame and length seen over stated. The straight line between the
    ends represents the body; a bent body is longer by a few hundredths.

    Raises: InputError where fewer than `MIN_SHARP_TRIALS` show both ends sharply in
    `MIN_SHARP_FRAMES_PER_TRIAL` frames.
    """
    parts = [
        found
        for t, (one, pairs, head_m) in enumerate(zip(trials, seen, head_lengths_m, strict=True))
        if (
            found := _whole_body_lengths_of_trial(
                one, np.asarray(pairs).reshape(-1, 2), robot.whole_length_m(head_m), t
            )
        )
    ]
    if len(parts) < MIN_SHARP_TRIALS:
        raise input_error("keypoints",
                          "", f"{len(parts)} trials in which nose and tail's end are seen",
                          f"{MIN_SHARP_TRIALS} with both in "
                          f"{MIN_SHARP_FRAMES_PER_TRIAL} frames")  # fmt: skip
    return RigidDistances(**{name: np.concatenate([p[name] for p in parts]) for name in parts[0]})


def systematic_length_error_share(geometry: CameraGeometry, distances: RigidDistances) -> float:
    """Relative error common to all trials where nothing is wrong: ruler, ends, motion blur."""
    ends = [pixels_of_places(geometry, end) for end in (distances.front_m, distances.back_m)]
    long_px = float(np.median(np.linalg.norm(ends[0] - ends[1], axis=1)))
    share = distances.excess_m / distances.known_m
    spread = [
        robust_std_and_inliers(share, distances.trial == t)[0] for t in np.unique(distances.trial)
    ]
    blur = MOTION_BLUR_ERROR_SHARE * float(np.median(spread))
    return float(np.sqrt(STATED_LENGTH_STD_SHARE**2 + (BODY_END_ERROR_PX / long_px) ** 2 + blur**2))


def _whole_body_lengths_of_trial(
    positions: KeypointPositions, pairs: Float, known_m: float, label: int
) -> dict[str, Float] | None:
    frames, ratio = pairs[:, 0].astype(int), pairs[:, 1]
    front, back = (positions.part(name)[frames] for name in WHOLE_LENGTH_END_PARTS)
    body = [positions.names.index(name) for name in REQUIRED_CONFIDENT_PARTS]
    good = is_confident(positions.likelihood[frames][:, body]).all(axis=1)
    good &= np.isfinite(ratio) & np.isfinite(front).all(axis=1) & np.isfinite(back).all(axis=1)
    if good.sum() < MIN_SHARP_FRAMES_PER_TRIAL:
        return None
    std, near = robust_std_and_inliers(ratio, good)
    if std > MAX_LENGTH_STD_SHARE:
        return None
    good &= near
    n = int(good.sum())
    return {
        "front_m": front[good],
        "back_m": back[good],
        "excess_m": (ratio[good] - 1.0) * known_m,
        "std_m": np.full(n, _equivalent_frame_std(std, n) * known_m),
        "known_m": np.full(n, known_m),
        "trial": np.full(n, float(label)),
        "pair": np.full(n, WHOLE_LENGTH_PAIR_NUMBER),
        "bend_rad": np.zeros(n),
        "time_s": positions.time_s[frames][good] - positions.time_s[0],
    }


def _equivalent_frame_std(std: float, frames: int) -> float:
    """Standard deviation of one frame for which all frames together have that of their trial."""
    return float(
        np.sqrt(
            std**2
            + frames * (TRIAL_TO_TRIAL_LENGTH_STD_SHARE**2 + (MOTION_BLUR_ERROR_SHARE * std) ** 2)
        )
    )
