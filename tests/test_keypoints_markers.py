"""Coloured dots: places to a small part of a pixel, whatever lies around; deviations that hold."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from bluekoi.keypoints import markers
from bluekoi.keypoints.dots.centroid import coverage_centroid
from bluekoi.keypoints.dots.variances import occlusion_variances

SKIN, WATER = np.array([84.0, 62, 47]), np.array([200.0, 190, 150])
RADIUS, FINER = 5.0, 8
COLOURS = {"yellow": (30.0, 205.0, 240.0), "red": (35.0, 40.0, 225.0), "green": (60.0, 190.0, 40.0)}


def dot_on_an_edge(centre: np.ndarray, colour: tuple[float, ...], edge: float) -> np.ndarray:
    """Picture (40, 40, 3) of a dot, half of it on the dark body, half before the bright water."""
    v, u = (np.indices((40 * FINER, 40 * FINER)) + 0.5) / FINER - 0.5
    fine = np.where((u + 0.3 * v < edge)[..., None], SKIN, WATER)
    fine = np.where((np.hypot(u - centre[0], v - centre[1]) < RADIUS)[..., None], colour, fine)
    coarse = fine.reshape(40, FINER, 40, FINER, 3).mean(axis=(1, 3))
    return cv2.GaussianBlur(coarse, (0, 0), 0.7)


@pytest.mark.parametrize("colour", list(COLOURS))
def test_a_dots_place_does_not_depend_on_what_lies_around_it(colour):
    rng = np.random.default_rng(3)
    off = []
    for _ in range(25):
        centre = 19.5 + rng.uniform(-1, 1, 2)
        clean = dot_on_an_edge(centre, COLOURS[colour], 25.0 + rng.uniform(-3, 3))
        image = np.clip(clean + rng.normal(0, 1.0, clean.shape), 0, 255).round().astype(np.uint8)
        place, area = coverage_centroid(image, centre + rng.uniform(-0.7, 0.7, 2), RADIUS)
        assert area == pytest.approx(np.pi * RADIUS**2, rel=0.1)
        off.append(place - centre)
    assert np.abs(np.mean(off, axis=0)).max() < 0.04
    assert np.sqrt(np.mean(np.square(off))) < 0.06


def test_where_there_is_no_dot_the_first_centre_is_kept():
    rng = np.random.default_rng(1)
    image = np.clip(SKIN + rng.normal(0, 2, (40, 40, 3)), 0, 255).astype(np.uint8)
    start = np.array([18.2, 21.7])
    place, area = coverage_centroid(image, start, RADIUS)
    assert place == pytest.approx(start)
    assert np.isnan(area)
    edge = np.array([1.0, 1.0])
    assert np.hypot(*(coverage_centroid(image, edge, RADIUS)[0] - edge)) <= RADIUS


def test_a_dot_of_which_a_part_is_hidden_is_known_less_well():
    area = np.full((60, 2), 78.0) + np.random.default_rng(0).normal(0, 0.5, (60, 2))
    area[30, 1] *= 0.6
    area[40, 0] = np.nan
    found = occlusion_variances(area, np.full((60, 2), 5.0))
    assert np.sqrt(found[30, 1]) == pytest.approx(0.4 * 4 * 5 / (3 * np.pi), rel=0.15)
    assert found[40, 0] > 1.0
    assert np.sqrt(np.delete(found[:, 1], 30)).max() < 0.05


def test_noise_that_lasts_is_seen_and_a_dot_that_whips_is_as_noisy_as_the_others():
    rng = np.random.default_rng(2)
    n, noise = 300, (0.05, 0.08, 0.10, 0.07, 0.07)
    rows = np.full((n, 5, 5), 1.0)
    rows[..., 3], rows[..., 4] = 78.0, 5.0
    along = np.array([120.0, 0, -25, -130, -190])
    rows[:, :, 0] = along + np.arange(n)[:, None] * 2.0
    rows[:, :, 1] = 0.0
    keep = 0.7
    error = rng.standard_normal((n, 5, 2))
    for k in range(1, n):
        error[k] = keep * error[k - 1] + np.sqrt(1 - keep**2) * error[k]
    rows[..., :2] += error * np.array(noise)[:, None]
    rows[:, 4, 1] += 15 * np.sin(np.arange(n) * 2.1)
    names = ("head_tip", "hinge", "core_center", "tail_base", "tail_tip")
    found = markers._keypoints_of_rows(np.arange(n) / 30, names, rows)
    assert np.sqrt(found.cov_px2[0, :, 0, 0]) == pytest.approx(noise, rel=0.3)
