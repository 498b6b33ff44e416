"""How the body goes along, roughly known beforehand: what the motion models take as given."""

from __future__ import annotations

import numpy as np

from ..data import Float
from .chain import Chain
from .grid import Grid
from .measured import Measured, measured
from .motion import planar_matrices
from .twin import smoothed

SLOWEST = 0.02
"""Pace below which the acceleration does not die out any slower."""
LIVELY = 0.3
"""Density of the rough filter's white acceleration, in usual speeds squared per unit of time."""
NEVER = 1e9
"""Time, s, in which an acceleration dies out that the rough filter does not have."""
ROUGH = 0.05
"""Noise of the rough filter's positions at least, in the way of a unit of time."""


def rough_speed(xy: Float, cov: Float, grid: Grid) -> Float:
    """Speed (nodes,) by a filter of white acceleration that follows a start but no tail beat."""
    data = measured(xy, cov, grid)
    n, T = len(xy), grid.scale_s
    noise = np.array([NEVER, LIVELY * data.speed**2 / T, 0.0, 0.0, 1.0])
    F, Q = planar_matrices(noise, grid.dt_s, 0.0, steady_course(n), np.zeros(n))
    F, Q = np.ascontiguousarray(F[:, :4, :4]), np.ascontiguousarray(Q[:, :4, :4])
    R = max(data.variance, (ROUGH * data.speed * T) ** 2) * np.eye(2)
    P0 = np.diag(np.repeat([np.ptp(data.z) ** 2 + R[0, 0], 9 * data.speed**2], 2))
    x0 = np.concatenate([data.z[data.plausible][0], np.zeros(2)])
    chain = Chain(F, Q, np.tile(np.eye(2, 4), (n, 1, 1)), np.tile(R, (n, 1, 1)), data.z, x0, P0)
    return np.asarray(np.linalg.norm(smoothed(chain, data.plausible).x[:, 2:], axis=1))


def steady_course(nodes: int) -> Float:
    """Course (nodes, 3) of a body at its usual pace that neither starts nor slips."""
    return np.tile([0.0, 1.0, 0.0], (nodes, 1))


def course(data: Measured, pace: Float, slip: Float, *, resting: bool) -> Float:
    """Columns kick, pace and slip (nodes, 3), see `motion`; the kick is that of a start from rest.

    pace: (nodes,) speed in any unit. slip: (nodes,) m^2/s^3.
    """
    usual = max(float(np.quantile(pace, 0.8)), 1e-300)
    return np.column_stack([data.kick * resting, np.maximum(pace / usual, SLOWEST), slip])
