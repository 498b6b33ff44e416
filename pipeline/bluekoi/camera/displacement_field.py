"""Displacement of a keypoint in the pool frame as a function of its position.

d(p) = c + g (p - p_0)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..data import Positions


class DisplacementField(NamedTuple):
    """c: displacement (x, y) at p_0, m; g: growth, m per m of distance from p_0; p_0: the middle
    (x, y) of all positions, m.
    """

    x_m: float
    y_m: float
    growth: float = 0.0
    middle_x_m: float = 0.0
    middle_y_m: float = 0.0


def without_displacements(
    positions: Positions, displacements: Mapping[str, DisplacementField]
) -> Positions:
    """Positions p = p_0 + (p' - p_0 - c) / (1 + g), from the measured positions p', of the
    displaced keypoints.
    """
    if not displacements:
        return positions
    none = DisplacementField(0.0, 0.0)
    fields = np.array([displacements.get(name, none) for name in positions.names])
    c, g, middle = fields[:, :2], fields[:, 2:3], fields[:, 3:]
    return replace(positions, xy_m=middle + (positions.xy_m - middle - c) / (1.0 + g))
