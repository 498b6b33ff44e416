"""Lens models against OpenCV and against themselves."""

import cv2
import numpy as np
import pytest

from bluekoi.camera.lens import (
    Lens,
    lens_from_parameters,
    lens_parameters,
    max_monotonic_radius,
    project_to_pixels,
    projection_derivatives,
    ray_directions,
)

MATRIX = np.array([[1130.0, 0, 955], [0, 1128, 542], [0, 0, 1]])
PINHOLES = {
    "none": [0, 0, 0, 0],
    "barrel": [-0.28, 0.09, 0.0004, -0.0003, -0.012],
    "pincushion": [0.2, 0.05, -0.001, 0.001, 0.01],
    "rational": [0.3, -0.02, 0.0005, 0.0002, 0.02, 0.4, 0.05, 0.01],
    "prism": [-0.2, 0.05, 0, 0, 0, 0, 0, 0, 0.001, 0.0002, -0.001, 0.0001],
    "tilted": [-0.2, 0.05, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.01, -0.02],
}
HERO11_WIDE = [0.034213889574, 0.067673207653, -0.074089699969, 0.029944425249]


def pixel_grid(width: int = 1920, height: int = 1080) -> np.ndarray:
    u, v = np.meshgrid(np.linspace(0, width - 1, 25), np.linspace(0, height - 1, 15))
    return np.column_stack([u.ravel(), v.ravel()])


@pytest.mark.parametrize("name", PINHOLES)
def test_pinhole_pixels_come_back_to_rounding(name):
    lens = Lens("pinhole", MATRIX, np.array(PINHOLES[name], dtype=float), (1920, 1080))
    again = project_to_pixels(lens, ray_directions(lens, pixel_grid()))
    assert np.abs(again - pixel_grid()).max() < 1e-7


def test_fisheye_pixels_come_back_and_agree_with_opencv():
    lens = Lens("fisheye", MATRIX, np.array(HERO11_WIDE), (1920, 1080))
    rays = ray_directions(lens, pixel_grid())
    assert np.abs(project_to_pixels(lens, rays) - pixel_grid()).max() < 1e-7
    theirs = cv2.fisheye.projectPoints(
        rays.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), MATRIX, np.array(HERO11_WIDE)
    )[0]
    assert np.abs(theirs.reshape(-1, 2) - pixel_grid()).max() < 1e-6


def test_fisheye_sees_past_ninety_degrees():
    lens = Lens("fisheye", MATRIX, np.zeros(4), (1920, 1080))
    ray = np.array([[np.sin(1.7), 0.0, np.cos(1.7)]])
    assert np.allclose(project_to_pixels(lens, ray), [[955 + 1130 * 1.7, 542]])
    assert np.allclose(ray_directions(lens, project_to_pixels(lens, ray)), ray)


def test_pinhole_agrees_with_opencv_forward():
    distortion = np.array(PINHOLES["barrel"])
    lens = Lens("pinhole", MATRIX, distortion, (1920, 1080))
    points = np.random.default_rng(1).uniform([-0.7, -0.4, 1], [0.7, 0.4, 1.1], (50, 3))
    theirs = cv2.projectPoints(points, np.zeros(3), np.zeros(3), MATRIX, distortion)[0]
    assert np.allclose(project_to_pixels(lens, points), theirs.reshape(-1, 2), atol=1e-9)


@pytest.mark.parametrize(
    ("model", "distortion"),
    [*(("pinhole", PINHOLES[name]) for name in ("none", "barrel", "rational")),
     ("fisheye", HERO11_WIDE)],
)  # fmt: skip
def test_slopes_of_pixels_are_those_of_central_differences(model, distortion):
    lens = Lens(model, MATRIX, np.array(distortion, dtype=float), (1920, 1080))
    points = np.random.default_rng(2).uniform([-0.6, -0.4, 0.8], [0.6, 0.4, 2.0], (40, 3))
    by_lens, by_point = projection_derivatives(lens, points)
    state, step = lens_parameters(lens), 1e-6
    for i, move in enumerate(step * np.eye(len(state))):
        ends = [
            project_to_pixels(lens_from_parameters(state + s * move, model, lens.size_px), points)
            for s in (1, -1)
        ]
        assert by_lens[:, :, i] == pytest.approx((ends[0] - ends[1]) / (2 * step), abs=1e-5)
    for i, move in enumerate(step * np.eye(3)):
        change = project_to_pixels(lens, points + move) - project_to_pixels(lens, points - move)
        assert by_point[:, :, i] == pytest.approx(change / (2 * step), abs=1e-5)


def test_points_that_are_not_seen_have_no_slope():
    lens = Lens("pinhole", MATRIX, np.array([-0.3, 0, 0, 0.0]), (1920, 1080))
    by_lens, by_point = projection_derivatives(lens, np.array([[2.0, 0.0, 1.0], [0.0, 0.0, -1.0]]))
    assert not by_lens.any()
    assert not by_point.any()


def test_points_past_the_fold_and_behind_are_not_seen():
    lens = Lens("pinhole", MATRIX, np.array([-0.3, 0, 0, 0.0]), (1920, 1080))
    assert max_monotonic_radius(lens) == pytest.approx(1 / np.sqrt(0.9), abs=0.01)
    points = np.array([[1.2, 0, 1], [0, 0, -1], [0.3, 0, 1]])
    assert np.isnan(project_to_pixels(lens, points)[:, 0]).tolist() == [True, True, False]
    edge = 955 + 1130 * max_monotonic_radius(lens) * (1 - 0.3 * max_monotonic_radius(lens) ** 2)
    seen = ray_directions(lens, np.array([[edge + 5, 542.0], [edge - 5, 542.0]]))
    assert np.isnan(seen[:, 0]).tolist() == [True, False]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("name", ["barrel", "rational"])
@pytest.mark.parametrize("far", [1e40, 1e80, 1e150, np.nan])
def test_pixels_beyond_all_numbers_have_no_direction_and_warn_of_nothing(name, far):
    lens = Lens("pinhole", MATRIX, np.array(PINHOLES[name], dtype=float), (1920, 1080))
    found = ray_directions(lens, np.array([[far, 500.0], [300.0, 300.0]]))
    assert np.all(np.isnan(found[0]))
    assert np.all(np.isfinite(found[1]))
