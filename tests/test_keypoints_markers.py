"""Coloured dots: places to a small part of a pixel, whatever lies around; deviations that hold."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from pipeline.keypoints import markers
from pipeline.keypoints.markers import unmixed

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
        off.append(unmixed(image, centre + rng.uniform(-0.7, 0.7, 2), RADIUS) - centre)
    assert np.abs(np.mean(off, axis=0)).max() < 0.04
    assert np.sqrt(np.mean(np.square(off))) < 0.06


def test_where_there_is_no_dot_the_first_centre_is_kept():
    rng = np.random.default_rng(1)
    image = np.clip(SKIN + rng.normal(0, 2, (40, 40, 3)), 0, 255).astype(np.uint8)
    start = np.array([18.2, 21.7])
    assert unmixed(image, start, RADIUS) == pytest.approx(start)
    edge = np.array([1.0, 1.0])
    assert np.hypot(*(unmixed(image, edge, RADIUS) - edge)) <= RADIUS


def test_a_dot_that_whips_is_as_noisy_as_the_others():
    rng = np.random.default_rng(2)
    n = 300
    rows = np.zeros((n, 4, 3))
    rows[..., 2] = 1.0
    rows[:, :, :2] = rng.normal(0, 0.08, (n, 4, 2)) + np.arange(n)[:, None, None] * 2.0
    rows[:, 3, 1] += 15 * np.sin(np.arange(n) * 2.1)
    found = markers._keypoints(np.arange(n) / 30, ("head_tip", "hinge", "core_center", "tail_tip"),
                               rows)  # fmt: skip
    assert np.sqrt(found.cov_px2[0, :, 0, 0]) == pytest.approx(np.full(4, 0.08), rel=0.25)
