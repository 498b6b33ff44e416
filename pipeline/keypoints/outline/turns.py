"""Which end is the front, told from all frames together: no body turns round between two frames."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Float = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
DOUBTFUL = 0.35


def turned_round(front: Float, rear: Float, reach: Float, weight: Float) -> tuple[Flags, Flags]:
    """Frames (n,) whose ends are the wrong way round, and frames in which that is in doubt.

    front, rear: (n, 2) px of the ends as found, NaN without a body. reach: (n,) px that the
    middle may move from frame to frame to be followed. weight: (n,) how surely the ends were told
    apart in a frame. Followed frames form a run, in which the ends are matched from frame to
    frame; the way round that has most of the weight counts for all of the run. A run is in doubt
    where the other way has more than DOUBTFUL of the weight.
    """
    middle = (front + rear) / 2
    moved = np.hypot(*np.diff(middle, axis=0).T)
    follows = np.concatenate([[False], moved <= reach[1:]])
    crossed = np.concatenate([[False], _crossed(front, rear)])
    wrong, doubt = np.zeros((2, len(front)), dtype=bool)
    starts = np.flatnonzero(~follows)
    for start, end in zip(starts, [*starts[1:], len(front)], strict=True):
        way = np.cumsum(crossed[start:end] & follows[start:end]) % 2 == 1
        total = float(weight[start:end].sum())
        share = float(weight[start:end][way].sum()) / total if total > 0 else 0.0
        wrong[start:end] = way if share <= 0.5 else ~way
        doubt[start:end] = min(share, 1 - share) > DOUBTFUL
    return wrong, doubt


def _crossed(front: Float, rear: Float) -> Flags:
    """Whether each frame's front lies where the rear was and its rear where the front was."""
    straight = np.hypot(*np.diff(front, axis=0).T) + np.hypot(*np.diff(rear, axis=0).T)
    across = np.hypot(*(front[1:] - rear[:-1]).T) + np.hypot(*(rear[1:] - front[:-1]).T)
    return across < straight
