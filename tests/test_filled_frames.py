"""Frames that were filled in afterwards are told from measured ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bluekoi.data import Keypoints
from bluekoi.pose.gap_filled_frames import (
    filled_gap_warnings,
    longest_filled_gap,
    without_filled_frames,
)

FRAMES, PARTS = 120, 4


def swimming_keypoints(rest_frames: int = 0) -> Keypoints:
    """Four keypoints on a turn, with a scatter of a twentieth of a pixel; first at rest."""
    rng = np.random.default_rng(1)
    time = np.arange(FRAMES) / 30.0
    angle = 0.8 * np.maximum(time - rest_frames / 30.0, 0.0)
    centre = 300.0 * np.column_stack([np.sin(angle), np.cos(angle)])
    xy = centre[:, None] + 20.0 * np.arange(PARTS)[None, :, None]
    xy[rest_frames:] += rng.normal(0, 0.05, (FRAMES - rest_frames, PARTS, 2))
    unknown = np.full((FRAMES, PARTS, 2, 2), np.nan)
    return Keypoints(time, tuple("abcd"), xy, np.ones((FRAMES, PARTS)), unknown)


def with_frames(keypoints: Keypoints, first: int, count: int, *, still: bool) -> Keypoints:
    """Frames replaced by points on straight lines, or by the pose before them."""
    xy = keypoints.xy_px.copy()
    share = np.zeros(count) if still else np.arange(1, count + 1) / (count + 1)
    begin, end = xy[first - 1], xy[min(first + count, FRAMES - 1)]
    xy[first : first + count] = begin + share[:, None, None] * (end - begin)
    return replace(keypoints, xy_px=np.round(xy, 3))


@pytest.mark.parametrize("still", [False, True])
def test_a_gap_that_was_filled_in_is_found(still: bool) -> None:
    gap = longest_filled_gap(with_frames(swimming_keypoints(), 60, 24, still=still))
    assert gap is not None
    assert 22 <= gap["frames"] <= 25
    assert gap["from_s"] == pytest.approx(60 / 30, abs=0.07)
    assert gap["to_s"] == pytest.approx(83 / 30, abs=0.07)


@pytest.mark.parametrize("still", [False, True])
def test_filled_frames_are_not_used_and_measured_ones_are(still: bool) -> None:
    filled = with_frames(swimming_keypoints(), 60, 24, still=still)
    unused = (without_filled_frames(filled).likelihood == 0.0).all(axis=1)
    assert unused[62:82].all()
    assert not unused[:59].any()
    assert not unused[85:].any()
    raw = swimming_keypoints()
    np.testing.assert_array_equal(without_filled_frames(raw).likelihood, raw.likelihood)


def test_the_filled_gaps_of_all_trials_are_named_in_one_sentence() -> None:
    gap = {"from_s": 2.0, "to_s": 2.7667, "frames": 24}
    (text,) = filled_gap_warnings({"T1": gap, "T2": gap})
    assert text.startswith(
        "In trials T1 from 2.00 to 2.77 s, T2 from 2.00 to 2.77 s, each keypoint"
    )
    assert filled_gap_warnings({}) == []


def test_measured_frames_and_a_robot_that_waits_are_not_called_filled() -> None:
    assert longest_filled_gap(swimming_keypoints()) is None
    assert longest_filled_gap(swimming_keypoints(rest_frames=40)) is None


def test_gaps_in_files_with_six_digits_are_found_beyond_a_thousand_pixels() -> None:
    """1000.43 and 999.431: the second difference of rounded points is up to 0.02."""
    seen = swimming_keypoints()
    far = replace(seen, xy_px=seen.xy_px + 1000.0)
    filled = with_frames(far, 60, 24, still=False)
    rounded = replace(filled, xy_px=np.round(filled.xy_px, 2))
    assert np.abs(np.diff(rounded.xy_px[61:82], n=2, axis=0)).max() > 0.005
    gap = longest_filled_gap(rounded)
    assert gap is not None
    assert 22 <= gap["frames"] <= 25
    assert longest_filled_gap(replace(far, xy_px=np.round(far.xy_px, 2))) is None


def test_keypoints_that_were_smoothed_are_not_called_filled() -> None:
    """Gaussian weights of seven frames, two decimals: straight for many frames, but measured."""
    rng, time = np.random.default_rng(3), np.arange(240) / 30.0
    x = 300.0 + 100.0 * time + 2.0 * np.sin(2.0 * np.pi * 2.4 * time)
    parts = x[:, None] + 20.0 * np.arange(PARTS) + rng.normal(0.0, 0.2, (240, PARTS))
    weights = np.exp(-0.5 * (np.arange(-21, 22) / 7.0) ** 2)
    smooth = np.apply_along_axis(
        lambda v: np.convolve(np.pad(v, 21, mode="reflect", reflect_type="odd"),
                              weights / weights.sum(), "valid"), 0, parts,
    )  # fmt: skip
    xy = np.round(np.stack([smooth, np.full_like(smooth, 400.0)], axis=2), 2)
    unknown = np.full((240, PARTS, 2, 2), np.nan)
    seen = Keypoints(time, tuple("abcd"), xy, np.ones((240, PARTS)), unknown)
    np.testing.assert_array_equal(without_filled_frames(seen).likelihood, seen.likelihood)


def test_points_of_low_likelihood_are_a_detectors_own_filling() -> None:
    filled = with_frames(swimming_keypoints(), 60, 24, still=False)
    likelihood = filled.likelihood.copy()
    likelihood[60:84] = 0.2
    assert longest_filled_gap(replace(filled, likelihood=likelihood)) is None
