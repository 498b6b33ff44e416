"""The tank's edge against its picture: speeds beat by beat, near it and far from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from bluekoi.data import Float

from ..averaging import block_means
from .reading import Run

AT_THE_EDGE = ("wall_effect", "edge_scale")
"""Held back by the edge, or only seen so: the two statements about y that rival each other."""
NEAR_M = 0.12
MIDDLE_M = (1.2, 4.8)
"""Where the robot has come to speed and has not yet come to the tank's end."""


@dataclass(frozen=True)
class Beats:
    """Speed (n,) from beat to beat and where it was, x (n,) and y (n,); gaps (n,): whether the
    light was lost in between.
    """

    speed: Float
    x: Float
    y: Float
    gaps: np.ndarray


def beats(run: Run) -> Beats:
    """Speeds of a run between the means of neighbouring beats."""
    times, places = block_means(run.times, run.places, 1.0 / run.beat_hz)
    step = np.diff(times)
    speed = np.hypot(*np.diff(places, axis=0).T) / step
    x, y = 0.5 * (places[1:] + places[:-1]).T
    frame = float(np.median(np.diff(run.times)))
    lost = run.times[:-1][np.diff(run.times) > 3.0 * frame]
    gaps = np.array([np.any((lost > a - step[0]) & (lost < b + step[0]))
                     for a, b in pairwise(times)])  # fmt: skip
    return Beats(speed, x, y, gaps)


def near_over_far(runs: Sequence[Run]) -> dict[str, tuple[float, int, int]]:
    """Command -> mean speed within 0.12 m of the edge over that farther off, and beats in both.

    Beats in the tank's middle in which the light was never lost; commands that have both.
    """
    out = {}
    for command in dict.fromkeys(r.condition for r in runs):
        own = [beats(r) for r in runs if r.condition == command]
        speed, x, y = (np.concatenate([getattr(b, k) for b in own]) for k in ("speed", "x", "y"))
        good = ~np.concatenate([b.gaps for b in own]) & (x > MIDDLE_M[0]) & (x < MIDDLE_M[1])
        near, far = good & (y < NEAR_M), good & (y >= NEAR_M)
        if near.any() and far.any():
            ratio = float(speed[near].mean() / speed[far].mean())
            out[command] = (ratio, int(near.sum()), int(far.sum()))
    return out
