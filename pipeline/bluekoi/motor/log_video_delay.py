"""Whether motor log and video begin together, by the phases of the tail beat.

A tail geared to the shaft is behind it by the same angle in every trial. A log whose clock is tau
ahead of the video's shows the shaft as it was tau earlier, so that trial k has the lag

    lag_k = lag_0 - 2 pi f_k tau,

which several flapping frequencies tell from lag_0 (the slope of phase over frequency: group delay).
"""

from __future__ import annotations

import numpy as np
from scipy.special import chdtri

from ..data import Float
from .shaft_angle import wrap_angle

MAX_DELAY_S = 2.0
"""Largest delay tried, and the spacing of those tried."""
DELAY_SEARCH_STEP_S = 0.002
REPEAT_FREQUENCY_TOLERANCE_SHARE = 0.03
"""Trials count as repeats whose frequencies differ by less than this share."""
MAX_LAG_SCATTER_RAD = 0.5
"""Where lags of repeats scatter by more, half a radian, phases no longer determine a delay."""
PHASE_LAG_STD_RAD = 0.05
"""ASSUME beyond a straight line over frequency, the lag of a tail varies by 3 degrees."""
UNMODELLED_TAIL_LAG_STD_S = (
    0.03  # ASSUME the lag that a tail gains with frequency looks like at most this delay
)
MIN_TRIALS_FOR_DELAY = 6
"""Trials without which no delay is estimated."""
MIN_FIT_P_VALUE = 1e-3
"""A fit whose misfit is less probable than this is refused."""
MIN_CHI2_GAIN_OVER_OTHER_DELAYS = 12.0
"""Any other delay must fit worse by this, in chi squared, but for what a hill is not a parabola."""
CHI2_NON_PARABOLIC_TOLERANCE = 1.0


def log_lead_from_beat_phases(
    flap_hz: Float, lag_rad: Float, std_rad: Float
) -> tuple[float, float] | None:
    """By how much the log's clock is ahead of the video's and the standard deviation, s, from the
    lags of the trials (n,); None where they are inconsistent or fit several delays. The scatter of
    lags is estimated from the trials at one frequency.
    """
    if len(flap_hz) < MIN_TRIALS_FOR_DELAY:
        return None
    repeats = are_repeats(flap_hz)
    scatter = _lag_std_of_repeats(lag_rad, repeats)
    if scatter > MAX_LAG_SCATTER_RAD:
        return None
    weights = 1.0 / (std_rad**2 + scatter**2 + repeats.sum(axis=1) * PHASE_LAG_STD_RAD**2)
    delays = np.arange(-MAX_DELAY_S, MAX_DELAY_S + DELAY_SEARCH_STEP_S / 2, DELAY_SEARCH_STEP_S)
    angles = lag_rad + 2 * np.pi * delays[:, None] * flap_hz
    middle = np.angle(np.exp(1j * angles) @ weights)
    misfit = wrap_angle(angles - middle[:, None]) ** 2 @ weights
    best = int(np.argmin(misfit))
    spread = weights @ (flap_hz - weights @ flap_hz / weights.sum()) ** 2
    if not spread > 0 or misfit[best] > chdtri(len(flap_hz) - 2, MIN_FIT_P_VALUE):
        return None
    std = float(1.0 / (2 * np.pi * np.sqrt(spread)))
    if std > MAX_DELAY_S:
        return None
    elsewhere = (
        np.abs(delays - delays[best])
        > np.sqrt(MIN_CHI2_GAIN_OVER_OTHER_DELAYS) * std + DELAY_SEARCH_STEP_S
    )
    if (
        elsewhere.any()
        and misfit[elsewhere].min()
        < misfit[best] + MIN_CHI2_GAIN_OVER_OTHER_DELAYS - CHI2_NON_PARABOLIC_TOLERANCE
    ):
        return None
    return float(delays[best]), float(np.hypot(std, UNMODELLED_TAIL_LAG_STD_S))


def are_repeats(flap_hz: Float) -> np.ndarray:
    """Whether trials flap at the same frequency, (n, n)."""
    return np.asarray(np.abs(np.log(flap_hz[:, None] / flap_hz)) < REPEAT_FREQUENCY_TOLERANCE_SHARE)


def _lag_std_of_repeats(lag_rad: Float, repeats: np.ndarray) -> float:
    """Standard deviation of the lags of repeats, rad: repeats (n, n) says which are."""
    middle = np.angle(repeats @ np.exp(1j * lag_rad))
    known = repeats.sum(axis=1) > 1
    freedom = float(np.sum(1.0 - 1.0 / repeats.sum(axis=1)))
    if freedom < 1:
        return 0.0
    return float(np.sqrt(np.sum(wrap_angle(lag_rad - middle)[known] ** 2) / freedom))
