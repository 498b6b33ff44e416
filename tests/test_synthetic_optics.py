"""The synthetic camera against Snell's law, OpenCV and an independent refractive package."""

import csv
import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from bluekoi.synthetic.optics import (
    Camera,
    displaced_camera,
    downward_rotation,
    gopro_like_camera,
    pixels_to_pool_points,
    pool_corners,
    pool_points_to_pixels,
    resized_camera,
    surface_point,
)

POOL = (2.6, 1.6)


def random_points(depth_m: float, count: int = 200) -> np.ndarray:
    rng = np.random.default_rng(3)
    x, y = rng.uniform(0, POOL[0], count), rng.uniform(0, POOL[1], count)
    return np.column_stack([x, y, np.full(count, -depth_m)])


@pytest.mark.parametrize("depth_m", [1e-6, 0.04, 0.3, 5.0])
def test_light_obeys_snell_at_the_surface(depth_m: float) -> None:
    camera, points = gopro_like_camera(), random_points(depth_m)
    surface = surface_point(camera, points)
    up = np.array(camera.centre_m) - surface
    down = surface - points
    sin_air = np.hypot(up[:, 0], up[:, 1]) / np.linalg.norm(up, axis=1)
    sin_water = np.hypot(down[:, 0], down[:, 1]) / np.linalg.norm(down, axis=1)
    assert np.allclose(sin_air, camera.index_water * sin_water, atol=1e-9)
    assert np.allclose(up[:, 0] * down[:, 1] - up[:, 1] * down[:, 0], 0, atol=1e-12)


def test_a_point_right_below_the_camera_is_not_bent() -> None:
    camera = gopro_like_camera()
    below = np.array([[camera.centre_m[0], camera.centre_m[1], -0.2]])
    assert np.allclose(surface_point(camera, below)[0, :2], camera.centre_m[:2], atol=1e-12)


@pytest.mark.parametrize("lens", ["pinhole", "fisheye"])
@pytest.mark.parametrize("depth_m", [0.0, 0.04, 0.3])
def test_pixel_and_back(lens: str, depth_m: float) -> None:
    camera, points = gopro_like_camera(lens), random_points(depth_m)
    back = pixels_to_pool_points(camera, pool_points_to_pixels(camera, points), depth_m)
    assert np.abs(back - points[:, :2]).max() < 1e-9


@pytest.mark.parametrize("lens", ["pinhole", "fisheye"])
def test_lens_agrees_with_opencv_above_water(lens: str) -> None:
    camera = gopro_like_camera(lens)
    points = random_points(-0.1)
    rotation = np.array(camera.rotation)
    shift = -rotation @ np.array(camera.centre_m)
    turn = cv2.Rodrigues(rotation)[0]
    (fx, fy), (cx, cy) = camera.focal_px, camera.middle_px
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
    model = cv2.fisheye if lens == "fisheye" else cv2
    pixels, _ = model.projectPoints(
        points[:, None, :], turn, shift, matrix, np.array(camera.distortion)
    )
    assert np.abs(pool_points_to_pixels(camera, points) - pixels[:, 0]).max() < 1e-6


def test_image_is_upright_and_not_mirrored() -> None:
    corners = pool_corners(gopro_like_camera(), POOL)
    assert corners[1, 0] > corners[0, 0] + 1000
    assert corners[3, 1] < corners[0, 1] - 500
    assert ((corners > 0) & (corners < np.array([1920, 1080]))).all()


def test_a_larger_picture_shows_the_same_field() -> None:
    camera, points = gopro_like_camera(), random_points(0.04)
    large = pool_points_to_pixels(resized_camera(camera, (3840, 2160)), points)
    assert np.allclose((large + 0.5) / 2 - 0.5, pool_points_to_pixels(camera, points), atol=1e-9)


def test_a_displacement_moves_the_picture_by_its_angle() -> None:
    camera = replace(
        gopro_like_camera(), rotation=downward_rotation(0, 0, 0), distortion=(0.0,) * 5
    )
    displaced = displaced_camera(camera, (0.0, 0.0, 0.0), (0.0, 0.25, 0.0))
    middle = pixels_to_pool_points(camera, np.array([camera.middle_px]), 0.0)
    place = np.array([[middle[0, 0], middle[0, 1], 0.0]])
    moved = pool_points_to_pixels(displaced, place)[0] - np.array(camera.middle_px)
    assert np.hypot(*moved) == pytest.approx(camera.focal_px[0] * np.tan(np.radians(0.25)))


@pytest.mark.recordings
def test_refraction_oracle_aquacal(recordings) -> None:
    setup = json.loads((recordings / "refraction" / "oracle_config.json").read_text())
    with (recordings / "refraction" / "oracle_projection.csv").open() as file:
        rows = np.array([[float(v) for v in row.values()] for row in csv.DictReader(file)])
    flip, water = np.diag([1.0, -1.0, -1.0]), setup["water_z_m"]
    rotation = np.array(setup["R_world_to_cam"]) @ flip
    centre = flip @ np.array(setup["C"]) + np.array([0, 0, water])
    matrix = setup["K"]
    camera = Camera(
        size_px=(3840, 2160),
        focal_px=(matrix[0][0], matrix[1][1]),
        middle_px=(matrix[0][2], matrix[1][2]),
        lens="pinhole",
        distortion=(0.0,) * 5,
        rotation=tuple(map(tuple, rotation)),
        centre_m=tuple(centre),
        index_water=setup["n_water"],
    )
    points = np.column_stack([rows[:, 0], -rows[:, 1], water - rows[:, 2]])
    assert np.abs(pool_points_to_pixels(camera, points) - rows[:, 4:6]).max() < 2e-6
    for row, point in zip(rows, points, strict=True):
        assert (
            np.abs(pixels_to_pool_points(camera, row[None, 4:6], row[3])[0] - point[:2]).max()
            < 1e-8
        )
