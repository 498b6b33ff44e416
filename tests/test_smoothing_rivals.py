"""Against the usual ways to a speed, each at the setting that is best over all motions."""

from __future__ import annotations

import numpy as np
import pytest

import rivals
from bluekoi.smoothing import smooth
from motions import MOTIONS, Seen, observe, times

FRAMES, SEEN = 150, Seen(hz=5.82, gap_s=(2.0, 2.3))


@pytest.fixture(scope="module")
def cases():
    rng = np.random.default_rng(21)
    made = [make(times(FRAMES)) for make in MOTIONS.values() for _ in range(2)]
    return [(truth, observe(truth, rng, SEEN)) for truth in made]


def error(cases, method) -> np.ndarray:
    """Root mean square error of speed and yaw rate over all cases."""
    squares = []
    for truth, pose in cases:
        velocity, rate = method(pose)
        speed = np.hypot(*velocity.T) - truth.speed
        squares.append([np.mean(speed**2), np.mean((rate - truth.yaw_rate) ** 2)])
    return np.sqrt(np.mean(squares, axis=0))


def ours(pose):
    track = smooth(pose, SEEN.hz)
    return np.column_stack([track.vx_m_s, track.vy_m_s]), track.yaw_rate_rad_s


@pytest.mark.long
def test_errors_are_at_least_30_percent_below_the_best_rival(cases):
    mine = error(cases, ours)
    for method, settings in rivals.settings(FRAMES).values():
        tried = [error(cases, lambda pose, s=s, m=method: m(pose, s)) for s in settings]
        assert (mine < 0.7 * np.min(tried, axis=0)).all(), method.__name__
