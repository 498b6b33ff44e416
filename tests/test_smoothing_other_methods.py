"""The smoother compared with other methods, each at its best setting over all motions."""

from __future__ import annotations

import numpy as np
import pytest

import other_smoothers
from bluekoi.smoothing import smooth_pose
from exact_motions import MOTIONS, CameraConditions, frame_times, observed_pose

FRAMES, SEEN = 150, CameraConditions(hz=5.82, gap_s=(2.0, 2.3))


@pytest.fixture(scope="module")
def cases():
    rng = np.random.default_rng(21)
    made = [make(frame_times(FRAMES)) for make in MOTIONS.values() for _ in range(2)]
    return [(truth, observed_pose(truth, rng, SEEN)) for truth in made]


def rms_errors(cases, method) -> np.ndarray:
    """Root mean square error of speed and yaw rate over all cases."""
    squares = []
    for truth, pose in cases:
        velocity, rate = method(pose)
        speed = np.hypot(*velocity.T) - truth.speed
        squares.append([np.mean(speed**2), np.mean((rate - truth.yaw_rate) ** 2)])
    return np.sqrt(np.mean(squares, axis=0))


def our_rates(pose):
    track = smooth_pose(pose, SEEN.hz)
    return np.column_stack([track.vx_m_s, track.vy_m_s]), track.yaw_rate_rad_s


@pytest.mark.long
def test_errors_are_at_least_30_percent_below_the_best_rival(cases):
    mine = rms_errors(cases, our_rates)
    for method, settings in other_smoothers.rival_settings(FRAMES).values():
        tried = [rms_errors(cases, lambda pose, s=s, m=method: m(pose, s)) for s in settings]
        assert (mine < 0.7 * np.min(tried, axis=0)).all(), method.__name__
