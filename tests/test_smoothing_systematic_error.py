"""Errors that last as long as the trial: stated by the detector, seen by no smoother."""

from __future__ import annotations

import numpy as np
import pytest

from bluekoi.data import Pose
from bluekoi.smoothing import smoothed_track_and_noise_ratio
from bluekoi.smoothing.systematic_error import with_systematic_error
from exact_motions import (
    MOTIONS,
    CameraConditions,
    circle,
    frame_times,
    observed_pose,
    straight_line,
)

FAST_BEAT = CameraConditions(hz=5.82, gap_s=(2.0, 2.3))


def observed_with_bias(make, seed: int, size: float = 2.0) -> tuple:
    """A motion seen with one more error, `size` times the noise, the same in all frames; stated."""
    rng = np.random.default_rng([41, seed])
    truth = make(frame_times(120))
    pose = observed_pose(truth, rng, FAST_BEAT)
    std = np.sqrt(np.einsum("nii->ni", pose.cov))
    values = pose.values + size * std * np.append(rng.normal(size=3), 0.0)
    return truth, Pose(pose.time_s, values, pose.cov * (1 + size**2))


@pytest.mark.long
def test_an_error_common_to_all_frames_is_in_the_deviations():
    before, after = [], []
    for seed, make in enumerate([*MOTIONS.values(), *MOTIONS.values()]):
        truth, pose = observed_with_bias(make, seed)
        track, shown = smoothed_track_and_noise_ratio(pose, FAST_BEAT.hz)
        whole = with_systematic_error(track, pose, shown)
        for found, pulls in ((track, before), (whole, after)):
            pulls.append((found.x_m - truth.xy[:, 0]) / found.x_m_std)
            pulls.append((found.y_m - truth.xy[:, 1]) / found.y_m_std)
            pulls.append((found.heading_rad - truth.heading) / found.heading_rad_std)
    assert np.sqrt(np.mean(np.square(before))) > 3
    assert 0.7 < np.sqrt(np.mean(np.square(after))) < 1.3


def test_where_the_noise_is_as_stated_nothing_is_added():
    pose = observed_pose(circle(frame_times(150)), np.random.default_rng(2), FAST_BEAT)
    track, shown = smoothed_track_and_noise_ratio(pose, FAST_BEAT.hz)
    whole = with_systematic_error(track, pose, shown)
    for name in ("x_m_std", "y_m_std", "heading_rad_std", "speed_m_s_std", "yaw_rate_rad_s_std"):
        assert getattr(whole, name) == pytest.approx(getattr(track, name))


def test_rates_are_given_a_change_of_the_error_in_the_trial():
    _, pose = observed_with_bias(straight_line, 1)
    track, shown = smoothed_track_and_noise_ratio(pose, FAST_BEAT.hz)
    whole = with_systematic_error(track, pose, shown)
    added = whole.yaw_rate_rad_s_std**2 - track.yaw_rate_rad_s_std**2
    position = whole.heading_rad_std**2 - track.heading_rad_std**2
    assert added == pytest.approx(2 * position / np.ptp(track.time_s) ** 2)
    assert (whole.speed_m_s_std > track.speed_m_s_std).all()
