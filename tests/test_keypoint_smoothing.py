"""Keypoints that were smoothed over time are recognised by rigid lengths that shrink in turns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_keypoint_displacement import ROBOT, circles

from bluekoi.camera.keypoint_displacement import estimate_keypoint_displacements
from bluekoi.camera.rigid_distances import RigidDistances, rigid_distances
from bluekoi.camera.rigid_length_warnings import rigid_length_warnings
from bluekoi.camera.smoothing_detection import (
    CAUSES_CONFOUNDED_WITH_SMOOTHING,
    estimate_keypoint_smoothing,
    undo_smoothing_of_lengths,
)
from bluekoi.data import KeypointPositions


def smoothed(one: KeypointPositions, frames: int) -> KeypointPositions:
    """A moving average, without the frames at both ends in which it is incomplete."""
    weights = np.ones(frames) / frames
    xy = np.apply_along_axis(lambda v: np.convolve(v, weights, "valid"), 0, one.xy_m)
    cut = slice(frames // 2, frames // 2 + len(xy))
    return KeypointPositions(one.time_s[cut], one.names, xy, one.cov_m2[cut], one.likelihood[cut])


def lengths(trials: list[KeypointPositions]) -> RigidDistances:
    return rigid_distances(trials, [0.12] * len(trials), ROBOT)


@pytest.mark.parametrize("frames", [15, 21])
def test_the_duration_of_a_moving_average_is_measured(frames):
    found = estimate_keypoint_smoothing(
        lengths([smoothed(one, frames) for one in circles(4, 0.0003)])
    )
    assert found.duration_s == pytest.approx(np.sqrt(frames**2 - 1) / 30.0, rel=0.15)


@pytest.mark.parametrize("seed", range(8))
def test_raw_keypoints_show_no_smoothing(seed):
    found = estimate_keypoint_smoothing(lengths(circles(seed)))
    assert not found.is_found
    assert 0.1 < found.least_duration_s < 1.0


def test_lengths_without_the_smoothing_are_the_stated_ones():
    shrunk = lengths([smoothed(one, 15) for one in circles(4, 0.0003)])
    found = estimate_keypoint_smoothing(shrunk)
    corrected = undo_smoothing_of_lengths(shrunk, found.variance_s2)
    fast = np.abs(shrunk.excess_m / shrunk.known_m) > 0.005
    before, after = (np.abs(np.mean((d.excess_m / d.known_m)[fast])) for d in (shrunk, corrected))
    assert before > 0.005
    assert after < 0.2 * before
    first = shrunk.trial == 0  # one trial alone was smoothed
    partly = undo_smoothing_of_lengths(shrunk, first * found.variance_s2)
    assert np.array_equal(partly.excess_m[first], corrected.excess_m[first])
    assert np.array_equal(partly.excess_m[~first], shrunk.excess_m[~first])


def test_a_keypoint_displaced_in_the_pool_is_no_smoothing():
    moved = [replace(one, xy_m=one.xy_m + np.array([[0.01, 0], [0, 0], [0, 0], [0, 0]]))
             for one in circles(5)]  # fmt: skip
    assert not estimate_keypoint_smoothing(lengths(moved)).is_found


def test_a_warning_says_what_is_not_judged():
    geometry = {"keypoint_smoothing": {"duration_s": 0.47, "variance_s2": 0.018, "sigmas": 24.0}}
    text = " ".join(rigid_length_warnings(geometry, None))
    assert "averaged over 0.47 s" in text
    assert "`_filtered`" in text
    assert all(name in text for name in CAUSES_CONFOUNDED_WITH_SMOOTHING)
    assert rigid_length_warnings({"keypoint_smoothing": None}, None) == []


def test_a_cause_that_invisible_smoothing_imitates_has_a_warning():
    named = {"causes": [{"name": "motor_spin_up", "weight": 0.9}]}
    (text,) = rigid_length_warnings({"least_visible_smoothing_s": 0.42}, named)
    assert "look like motor_spin_up" in text
    assert "less than 0.42 s" in text
    assert rigid_length_warnings({"least_visible_smoothing_s": 0.12}, named) == []
    assert rigid_length_warnings({"least_visible_smoothing_s": None}, named) == []
    assert rigid_length_warnings({"least_visible_smoothing_s": 0.42}, {"causes": []}) == []


def test_files_without_a_core_centre_show_neither_error():
    """Only the head's length is checked then, which is not enough."""
    kept = [0, 1, 3]
    raw = [KeypointPositions(one.time_s, tuple(np.array(one.names)[kept]), one.xy_m[:, kept],
                     one.cov_m2[:, kept], one.likelihood[:, kept])
           for one in circles(4)]  # fmt: skip
    assert not estimate_keypoint_smoothing(lengths(raw)).is_found
    assert estimate_keypoint_displacements(raw, [0.12] * len(raw), ROBOT) == {}
