"""Systematic errors: the part of the stated measurement error that does not show as noise.

A detector may know that its points are off by more than they jitter: an edge that is soft on one
side, a template that is a little too long. Such an error is the same in all frames, or changes as
slowly as the view does. No smoother sees it, and it belongs to the deviations.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..data import Float, Pose, Track

MAX_NOISE_RATIO_WITH_SYSTEMATIC_ERROR = 0.67
"""A noise ratio of at least this counts as 1."""


def with_systematic_error(track: Track, pose: Pose, noise_ratio: tuple[float, float]) -> Track:
    """The track, its deviations widened by the stated error that does not show as noise.

    Variance u = (1 - noise_ratio) stated, of each position and of the heading; rates get
    2 u / span^2, the error changing once in the trial. noise_ratio: of positions and heading.
    """
    stated = np.nanmedian(np.einsum("nii->ni", pose.cov[:, :3, :3]), axis=0)
    hidden = [
        1 - share if share < MAX_NOISE_RATIO_WITH_SYSTEMATIC_ERROR else 0.0
        for share in (noise_ratio[0], *noise_ratio)
    ]
    x, y, heading = map(float, stated * hidden)
    turn = 2 / float(np.ptp(track.time_s)) ** 2
    return replace(
        track,
        x_m_std=_widen_std(track.x_m_std, x),
        y_m_std=_widen_std(track.y_m_std, y),
        heading_rad_std=_widen_std(track.heading_rad_std, heading),
        vx_m_s_std=_widen_std(track.vx_m_s_std, turn * x),
        vy_m_s_std=_widen_std(track.vy_m_s_std, turn * y),
        speed_m_s_std=_widen_std(track.speed_m_s_std, turn * 0.5 * (x + y)),
        yaw_rate_rad_s_std=_widen_std(track.yaw_rate_rad_s_std, turn * heading),
    )


def _widen_std(std: Float, variance: float) -> Float:
    return np.asarray(np.sqrt(std**2 + variance))
