"""Keypoints that were smoothed over time before they were given to BlueKoi.

Let the smoothing be a weighted mean over time whose weights have the standard deviation s. For a
moving average over the duration T, s = T / sqrt(12). A rigid length that turns at the yaw rate r is
then averaged over directions, and becomes shorter:

    y = -(r s)^2 L / 2    for r s << 1.

No error of camera or geometry shortens rigid lengths in proportion to the square of the yaw rate.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..data import Float
from .keypoint_displacement import displacement_design_matrix
from .rigid_distances import RigidDistances
from .rigid_length_regression import directions_of_lengths, regress_length_errors
from .rigid_length_windows import window_means

MIN_SMOOTHING_SIGMAS = 5.0
"""Standard errors from 0 beyond which keypoints count as smoothed. Fifteen studies of `campus_pool`
5841, `tidal_lock` 9402 and `leading_plate` 5701 with raw keypoints reach 3.2."""
SMOOTHING_VARIANCE_PRIOR_STD_S2 = 1.0 / 36.0
"""Prior standard deviation of s^2, wide: that of a moving average over 0.6 s."""
MIN_WINDOWS_FOR_YAW_RATE = 3

CAUSES_CONFOUNDED_WITH_SMOOTHING = ("lift_lag", "motor_spin_up", "servo_lag", "time_offset")
"""Causes that act for a fraction of a second after a sudden change. Smoothing makes all changes
slow in the same way."""


@dataclass(frozen=True)
class KeypointSmoothingEstimate:
    """Duration of the moving average that shortens lengths as they are found.

    variance_s2: s^2, of the weights. sigmas: distance of s^2 from 0 in standard errors.
    least_duration_s: duration of the shortest moving average that these lengths would show.
    """

    duration_s: float
    variance_s2: float
    sigmas: float
    least_duration_s: float

    @property
    def is_found(self) -> bool:
        """Whether the keypoints count as smoothed."""
        return self.sigmas > MIN_SMOOTHING_SIGMAS


def estimate_keypoint_smoothing(distances: RigidDistances) -> KeypointSmoothingEstimate | None:
    """The smoothing that rigid lengths (n,) of all trials show, or would show at least; None where
    too few lengths turn.
    """
    windows = window_means(distances)
    rates = yaw_rates_from_length_directions(windows, windows)
    known = np.isfinite(rates)
    windows, rates = windows.select(known), rates[known]
    if not len(rates):
        return None
    _, displaced, displaced_stds = displacement_design_matrix(windows)
    columns = np.column_stack([-0.5 * windows.known_m * rates**2, displaced])
    stds = np.concatenate([[SMOOTHING_VARIANCE_PRIOR_STD_S2], displaced_stds])
    estimate, cov, _ = regress_length_errors(windows, columns, stds)
    std = float(np.sqrt(cov[0, 0]))
    variance_s2 = float(max(estimate[0], 0.0))
    return KeypointSmoothingEstimate(
        duration_s=float(np.sqrt(12.0 * variance_s2)), variance_s2=variance_s2,
        sigmas=float(estimate[0]) / std,
        least_duration_s=float(np.sqrt(12.0 * MIN_SMOOTHING_SIGMAS * std)),
    )  # fmt: skip


def undo_smoothing_of_lengths(
    distances: RigidDistances, variance_s2: float | Float
) -> RigidDistances:
    """Lengths (n,) as they would be without a smoothing of this variance of the weights, s^2, or of
    these variances (n,).
    """
    rates = np.nan_to_num(yaw_rates_from_length_directions(window_means(distances), distances))
    lost = 0.5 * distances.known_m * variance_s2 * rates**2
    return replace(distances, excess_m=distances.excess_m + lost)


def yaw_rates_from_length_directions(windows: RigidDistances, at: RigidDistances) -> Float:
    """Yaw rate (n,) of each length of `at`, rad/s, from the directions of consecutive windows.

    windows: means over short windows. NaN for lengths with fewer than `MIN_WINDOWS_FOR_YAW_RATE` in
    their trial.
    """
    along = directions_of_lengths(windows)
    angle = np.arctan2(along[:, 1], along[:, 0])
    rates = np.full(len(at.excess_m), np.nan)
    for trial, pair in np.unique(np.column_stack([windows.trial, windows.pair]), axis=0):
        own = np.flatnonzero((windows.trial == trial) & (windows.pair == pair))
        if len(own) < MIN_WINDOWS_FOR_YAW_RATE:
            continue
        own = own[np.argsort(windows.time_s[own])]
        times = windows.time_s[own]
        rate = np.gradient(np.unwrap(angle[own]), times)
        here = (at.trial == trial) & (at.pair == pair)
        rates[here] = np.interp(at.time_s[here], times, rate)
    return rates
