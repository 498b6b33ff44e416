"""The body's whole length, nose to tail, as footage shows it: what keypoints that were placed at
stated lengths cannot say of scale.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data import Float, Positions
from ..faults import fault
from ..study import Robot
from .distances import LENGTH_STD, Distances, Geometry, pixels_of, scatter
from .pool import CONFIDENT

WHOLE = "whole length"
"""What geometry.json says it rests on where rigid distances say nothing."""
ENDS = ("head_tip", "tail_tip")
BELIEVED = ("head_tip", "hinge", "core_center")
"""The tail's own likelihood is not asked: it is less where the tail is shorter than stated."""
PAIR = 3.0
"""Its number among the pairs: no keypoint's bias changes it."""
END_PX, SMEARED = 0.5, 0.8
"""An end is seen half a pixel short where nothing is wrong, and by this share of the frames' spread
where the exposure smears it (docs/measuring.md).
"""
LASTING = 0.003
"""Each trial's frames err together by so much: many frames are no surer than that."""
LEAST_TRIALS = 3
MOST_SPREAD = 0.006
"""A trial whose frames differ by more was filmed with so long an exposure that its tail has no end.
"""
LEAST_FRAMES = 10


def whole_lengths(
    trials: Sequence[Positions],
    seen: Sequence[Float],
    head_lengths_m: Sequence[float],
    robot: Robot,
) -> Distances:
    """Whole lengths of all trials against the stated ones.

    seen: of each trial (n, 2) frame and length seen over stated. The straight line between the
    ends stands for the body; what it lacks where the body is bent is a few hundredths.

    Raises: Fault where fewer than `LEAST_TRIALS` show both ends sharply in `LEAST_FRAMES` frames.
    """
    core_m = robot.hinge_to_com_m + robot.com_to_tail_base_m
    rest_m = core_m + robot.tail_length_m
    parts = [
        found
        for t, (one, pairs, head_m) in enumerate(zip(trials, seen, head_lengths_m, strict=True))
        if (found := _of_trial(one, np.asarray(pairs).reshape(-1, 2), head_m + rest_m, t))
    ]
    if len(parts) < LEAST_TRIALS:
        raise fault("keypoints", "", f"{len(parts)} trials in which nose and tail's end are seen",
                    f"{LEAST_TRIALS} trials with both in {LEAST_FRAMES} frames")  # fmt: skip
    return Distances(**{name: np.concatenate([p[name] for p in parts]) for name in parts[0]})


def systematic(geometry: Geometry, distances: Distances) -> float:
    """Share by which seen and stated lengths may differ in all trials where nothing is wrong: by
    the ruler, by where an end is seen, by what the exposure smears.
    """
    ends = [pixels_of(geometry, end) for end in (distances.front_m, distances.back_m)]
    long_px = float(np.median(np.linalg.norm(ends[0] - ends[1], axis=1)))
    share = distances.excess_m / distances.known_m
    spread = [scatter(share, distances.trial == t)[0] for t in np.unique(distances.trial)]
    smeared = SMEARED * float(np.median(spread))
    return float(np.sqrt(LENGTH_STD**2 + (END_PX / long_px) ** 2 + smeared**2))


def _of_trial(
    positions: Positions, pairs: Float, known_m: float, label: int
) -> dict[str, Float] | None:
    frames, ratio = pairs[:, 0].astype(int), pairs[:, 1]
    front, back = (positions.part(name)[frames] for name in ENDS)
    body = [positions.names.index(name) for name in BELIEVED]
    good = np.all(positions.likelihood[frames][:, body] >= CONFIDENT, axis=1)
    good &= np.isfinite(ratio) & np.isfinite(front).all(axis=1) & np.isfinite(back).all(axis=1)
    if good.sum() < LEAST_FRAMES:
        return None
    std, near = scatter(ratio, good)
    if std > MOST_SPREAD:
        return None
    good &= near
    n = int(good.sum())
    return {
        "front_m": front[good],
        "back_m": back[good],
        "excess_m": (ratio[good] - 1.0) * known_m,
        "std_m": np.full(n, _lasting(std, n) * known_m),
        "known_m": np.full(n, known_m),
        "trial": np.full(n, float(label)),
        "pair": np.full(n, PAIR),
        "bend_rad": np.zeros(n),
        "time_s": positions.time_s[frames][good] - positions.time_s[0],
    }


def _lasting(std: float, frames: int) -> float:
    """Deviation of one frame such that all frames of a trial together have that of the trial."""
    return float(np.sqrt(std**2 + frames * (LASTING**2 + (SMEARED * std) ** 2)))
