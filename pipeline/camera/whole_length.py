"""The body's whole length, nose to tail, as footage shows it: what keypoints that were placed at
stated lengths cannot say of scale.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..data import Float, Positions
from ..faults import fault
from ..study import Robot
from .distances import ROBUST_WIDTH, WIDEST_MISS, Distances

ENDS = ("head_tip", "tail_tip")
WHOLE = 3.0
"""Its number among the pairs: no keypoint's bias changes it."""
SYSTEMATIC = 0.004
"""Seen and stated length differ by up to 0.25 % where nothing is wrong (docs/measuring.md), and a
ruler along a body is not surer than that.
"""
LASTING = 0.003
"""Each trial's frames err together by so much: many frames are no surer than that."""
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

    Raises: Fault where no trial shows both ends sharply in `LEAST_FRAMES` frames.
    """
    core_m = robot.hinge_to_com_m + robot.com_to_tail_base_m
    rest_m = core_m + robot.tail_length_m
    parts = [
        found
        for t, (one, pairs, head_m) in enumerate(zip(trials, seen, head_lengths_m, strict=True))
        if (found := _of_trial(one, np.asarray(pairs).reshape(-1, 2), head_m + rest_m, t))
    ]
    if not parts:
        raise fault("keypoints", "", "no trial in which nose and tail's end are seen",
                    f"both in {LEAST_FRAMES} frames of some trial")  # fmt: skip
    return Distances(**{name: np.concatenate([p[name] for p in parts]) for name in parts[0]})


def _of_trial(
    positions: Positions, pairs: Float, known_m: float, label: int
) -> dict[str, Float] | None:
    frames, ratio = pairs[:, 0].astype(int), pairs[:, 1]
    front, back = (positions.part(name)[frames] for name in ENDS)
    good = np.isfinite(ratio) & np.isfinite(front).all(axis=1) & np.isfinite(back).all(axis=1)
    if good.sum() < LEAST_FRAMES:
        return None
    miss = ratio - np.median(ratio[good])
    std = max(1e-6, ROBUST_WIDTH * float(np.median(np.abs(miss[good]))))
    if std > MOST_SPREAD:
        return None
    good &= np.abs(miss) < WIDEST_MISS * std
    n = int(good.sum())
    return {
        "front_m": front[good],
        "back_m": back[good],
        "excess_m": (ratio[good] - 1.0) * known_m,
        "std_m": np.full(n, float(np.hypot(std, LASTING * n**0.5)) * known_m),
        "known_m": np.full(n, known_m),
        "trial": np.full(n, float(label)),
        "pair": np.full(n, WHOLE),
        "bend_rad": np.zeros(n),
        "time_s": positions.time_s[frames][good] - positions.time_s[0],
    }
