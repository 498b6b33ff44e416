"""Drift of the tail beat in the video: exact beats with a known change of frequency."""

import numpy as np
import pytest
from test_motor import positions_with_tail_angles

from bluekoi.motor.tail_beat_drift import tail_beat_drift


def drifting_beat(rng, hz, drift, *, frames=300, fps=25.0, noise=0.03):
    """Positions whose tail's frequency hz changes by the share `drift` a second about the middle of
    what comes after the spin-up.
    """
    t = np.arange(frames) / fps
    since = t - 0.5 * (2.0 + t[-1])
    tail = 0.3 * np.sin(2 * np.pi * hz * (since + 0.5 * drift * since**2) + 0.4)
    return positions_with_tail_angles(t, tail + rng.normal(0, noise, frames))


@pytest.mark.parametrize("drift", [-0.04, -0.015, 0.0, 0.02])
@pytest.mark.parametrize("hz", [2.1, 4.7])
def test_drift_of_a_beat_is_found_within_its_standard_deviation(hz, drift):
    found, std = tail_beat_drift(drifting_beat(np.random.default_rng(4), hz, drift), 1.02 * hz)
    assert abs(found - drift) < 4 * std
    assert std < 0.001


def test_standard_deviation_of_the_drift_is_that_of_its_errors():
    rng = np.random.default_rng(5)
    errors = []
    for _ in range(25):
        found, std = tail_beat_drift(drifting_beat(rng, 3.3, -0.01, noise=0.1), 3.3)
        errors.append((found + 0.01) / std)
    assert 0.7 < np.sqrt(np.mean(np.square(errors))) < 1.4


def test_noise_alone_shows_no_beat():
    t, rng = np.arange(250) / 25.0, np.random.default_rng(6)
    for _ in range(20):
        still = positions_with_tail_angles(t, rng.normal(0, 0.1, len(t)))
        assert np.isnan(tail_beat_drift(still, 3.0)).all()


def test_few_frames_and_beats_faster_than_the_camera_show_no_drift():
    beat = drifting_beat(np.random.default_rng(7), 3.0, -0.02, frames=60)
    assert np.isnan(tail_beat_drift(beat, 3.0)).all()
    fast = drifting_beat(np.random.default_rng(8), 14.0, -0.02)
    assert np.isnan(tail_beat_drift(fast, 14.0)).all()


def test_a_long_recording_is_measured_over_its_first_beats():
    """Of 40 minutes at 5 Hz, 12,000 beats, the first minute is used."""
    found, std = tail_beat_drift(
        drifting_beat(np.random.default_rng(9), 5.0, 0.0, frames=60_000, fps=25.0), 5.0
    )
    assert abs(found) < 4 * std < 0.001


@pytest.mark.parametrize("frame_s", [1000.0, 1e-6])
def test_absurd_frame_rates_take_no_longer(frame_s):
    """The number of beats limits the work, not the stated time."""
    t = np.arange(300) * frame_s
    beat = positions_with_tail_angles(t, 0.3 * np.sin(2 * np.pi * 0.1 * np.arange(300)))
    found, _ = tail_beat_drift(beat, 0.1 / frame_s)
    assert np.isnan(found) or abs(found) * t[-1] < 1.0
