"""Polars of a plate over the full circle, tabulated and interpolated."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NODE_COUNT = 7200
ANGLE_GRID_RAD: Array = np.linspace(-np.pi, np.pi, NODE_COUNT + 1)
"""Angles of attack of the tables, rad."""


def flat_plate() -> Array:
    """Lift, drag rise and moment for unit coefficients, shape (3, nodes).

    sin 2a, 1 - cos 2a, sin 2a: Eqs. (5) to (7) of the published model.
    """
    return np.stack(
        [np.sin(2 * ANGLE_GRID_RAD), 1 - np.cos(2 * ANGLE_GRID_RAD), np.sin(2 * ANGLE_GRID_RAD)]
    )


def thin_fin(stall_rad: float, width_rad: float) -> Array:
    """Lift and drag of a fin of low aspect ratio per unit lift slope, shape (2, nodes).

    Attached: potential lift sin a cos a. Separated: normal force 1.1 sin a (broad plate, Hoerner,
    Fluid-Dynamic Drag, ch. 3) resolved across and along the flow; a logistic blend between them.
    """
    steep = np.arcsin(np.abs(np.sin(ANGLE_GRID_RAD)))
    attached = 1 / (1 + np.exp((steep - stall_rad) / width_rad))
    normal = 1.1 / np.pi * np.sin(ANGLE_GRID_RAD)
    lift = attached * np.sin(ANGLE_GRID_RAD) * np.cos(ANGLE_GRID_RAD) + (
        1 - attached
    ) * normal * np.cos(ANGLE_GRID_RAD)
    drag = (1 - attached) * normal * np.sin(ANGLE_GRID_RAD)
    return np.stack([lift, drag])


def interpolate_polar(table: Array, alpha: Array) -> Array:
    """Values (rows, lanes) of a table (rows, nodes) at angles of attack in (-pi, pi], (lanes,)."""
    at = (alpha + np.pi) * (NODE_COUNT / (2 * np.pi))
    low = np.clip(at.astype(np.intp), 0, NODE_COUNT - 1)
    return table[:, low] + (at - low) * (table[:, low + 1] - table[:, low])
