"""Times of the filter: those of the frames, and between distant frames some more."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..data import BoolNDArray, Float

MAX_STEP_FRAMES = 1.5
"""No step of the filter is longer than so many usual frame intervals."""


@dataclass(frozen=True)
class FilterTimeGrid:
    """time_s, dt_s: (nodes,); frame: (nodes,) whether a node is a frame; scale_s: unit of time.

    The unit is the least number of whole tail beats that takes ten frames.
    """

    time_s: Float
    dt_s: Float
    frame: BoolNDArray
    scale_s: float

    def frame_values_on_nodes(self, values: Float) -> Float:
        """Values of the frames (frames, ...) spread over the nodes, NaN between."""
        out = np.full((len(self.time_s), *values.shape[1:]), np.nan)
        out[self.frame] = values
        return out


def filter_time_grid(time_s: Float, flap_hz: float) -> FilterTimeGrid:
    """Nodes for frames at time_s (frames,), s; dropped frames leave room for nodes of their own."""
    usual = float(np.median(np.diff(time_s)))
    pieces, marks = [time_s[:1]], [np.array([True])]
    for first, last in pairwise(time_s):
        count = max(int(np.ceil((last - first) / (MAX_STEP_FRAMES * usual))), 1)
        pieces.append(first + (last - first) * np.arange(1, count + 1) / count)
        marks.append(np.arange(1, count + 1) == count)
    nodes, frame = np.concatenate(pieces), np.concatenate(marks)
    scale = np.ceil(10 * usual * flap_hz) / flap_hz if flap_hz > 0 else 10 * usual
    return FilterTimeGrid(nodes, np.diff(nodes, prepend=nodes[0]), frame, float(scale))
