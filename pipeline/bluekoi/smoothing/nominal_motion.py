"""Nominal motion: speed and onset, roughly known before the fit, that the motion models need."""

from __future__ import annotations

import numpy as np

from ..data import Float
from .grid import FilterTimeGrid
from .kalman_numba import compiled_filter_and_smooth
from .linear_gaussian import LinearGaussianModel
from .motion import planar_matrices
from .screening import ScreenedMeasurements, screen_measurements

MIN_RELATIVE_SPEED = 0.02
"""Relative speed below which the acceleration does not decay any slower."""
RELATIVE_ACCELERATION_DENSITY = 0.3
"""Density of the rough filter's white acceleration, in usual speeds squared per unit of time."""
NO_DECAY_S = 1e9
"""Decay time, s, of the acceleration, which the rough filter does not have."""
MIN_POSITION_STD_SHARE = 0.05
"""Least noise of the rough filter's positions, in usual speeds times the unit of time."""


def rough_speed(xy: Float, cov: Float, grid: FilterTimeGrid) -> Float:
    """Speed (nodes,) by a filter with white acceleration that follows a start but no tail beat."""
    data = screen_measurements(xy, cov, grid)
    n, T = len(xy), grid.scale_s
    noise = np.array([NO_DECAY_S, RELATIVE_ACCELERATION_DENSITY * data.speed**2 / T, 0.0, 0.0, 1.0])
    F, Q = planar_matrices(noise, grid.dt_s, 0.0, nominal_motion_without_onset(n), np.zeros(n))
    F, Q = np.ascontiguousarray(F[:, :4, :4]), np.ascontiguousarray(Q[:, :4, :4])
    R = max(data.variance, (MIN_POSITION_STD_SHARE * data.speed * T) ** 2) * np.eye(2)
    P0 = np.diag(np.repeat([np.ptp(data.z) ** 2 + R[0, 0], 9 * data.speed**2], 2))
    x0 = np.concatenate([data.z[data.plausible][0], np.zeros(2)])
    H, noise_cov = np.tile(np.eye(2, 4), (n, 1, 1)), np.tile(R, (n, 1, 1))
    model = LinearGaussianModel(F, Q, H, noise_cov, data.z, x0, P0)
    return np.asarray(
        np.linalg.norm(compiled_filter_and_smooth(model, data.plausible).x[:, 2:], axis=1)
    )


def nominal_motion_without_onset(nodes: int) -> Float:
    """Nominal motion (nodes, 3) at the usual speed, without onset or heading noise."""
    return np.tile([0.0, 1.0, 0.0], (nodes, 1))


def nominal_motion(
    data: ScreenedMeasurements, speed: Float, heading_noise: Float, *, resting: bool
) -> Float:
    """Columns onset, relative speed and heading noise (nodes, 3), see `motion`.

    The onset is that of a start from rest. speed: (nodes,) in any unit. heading_noise: (nodes,)
    m^2/s^3.
    """
    usual = max(float(np.quantile(speed, 0.8)), 1e-300)
    relative = np.maximum(speed / usual, MIN_RELATIVE_SPEED)
    return np.column_stack([data.onset * resting, relative, heading_noise])
