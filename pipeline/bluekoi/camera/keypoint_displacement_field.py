"""Displacement of a keypoint as a function of its position p in the pool frame.

    d(p) = a + g p

A constant displacement has g = 0. A keypoint that lies higher than the others has the parallax g
and is displaced away from the point below the camera, at which d = 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..data import Float, KeypointPositions


class KeypointDisplacementField(NamedTuple):
    """a: displacement (x, y) at the origin of the pool frame, m; g: parallax, m per m."""

    x_m: float
    y_m: float
    parallax: float = 0.0

    def at(self, positions_m: Float) -> Float:
        """Displacements (..., 2) at positions (..., 2), m."""
        return np.asarray([self.x_m, self.y_m] + self.parallax * positions_m)


NO_DISPLACEMENT = KeypointDisplacementField(0.0, 0.0)


def remove_keypoint_displacements(
    positions: KeypointPositions, displacements: Mapping[str, KeypointDisplacementField]
) -> KeypointPositions:
    """Positions with p = (p' - a) / (1 + g) in place of the p' of displaced keypoints."""
    if not displacements:
        return positions
    fields = np.array([displacements.get(name, NO_DISPLACEMENT) for name in positions.names])
    a, g = fields[:, :2], fields[:, 2:]
    return replace(positions, xy_m=(positions.xy_m - a) / (1.0 + g))
