"""A moved camera is distinguished from a fixed one, whatever the light and the noise."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from bluekoi.data import Frame
from bluekoi.keypoints.outline.camera_motion import (
    camera_motion_remarks,
    corner_shifts,
    corner_shifts_of_camera_motion,
)
from bluekoi.keypoints.outline.plane import SwimmingPlaneMap, swimming_plane_map
from bluekoi.study import StudySettings

CORNERS = ((60.0, 420.0), (580.0, 420.0), (580.0, 100.0), (60.0, 100.0))


def make_plane() -> SwimmingPlaneMap:
    """A pool of 2.6 x 1.6 m seen straight from above at 200 px per m."""
    robot = {
        "mass_kg": 1, "yaw_inertia_kg_m2": 0.005, "body_length_m": 0.3, "head_length_m": 0.12,
        "head_span_m": 0.07, "hinge_to_com_m": 0.04, "tail_length_m": 0.06,
    }  # fmt: skip
    return swimming_plane_map(StudySettings(robot=robot, camera={"pool_corners_px": CORNERS}))


def pool_picture(move: np.ndarray | None = None) -> np.ndarray:
    """Picture of a tiled pool with a wall, moved by an affine matrix (2, 3)."""
    image = np.full((520, 680), 90.0, np.float32)
    image[100:421, 60:581] = 190.0
    image[100:421, 60:581:40] = 140.0
    image[100:421:40, 60:581] = 140.0
    image = cv2.GaussianBlur(image, (0, 0), 1.0)
    return image if move is None else cv2.warpAffine(image, move, image.shape[::-1])


def noisy_frames(pictures: list[np.ndarray], noise: float = 3.0) -> list[Frame]:
    """Frames with noise that is one pattern shifted about, as a sensor's readout may give."""
    rng = np.random.default_rng(1)
    grain = rng.normal(0.0, noise, pictures[0].shape)
    rolled = [np.roll(grain, tuple(rng.integers(0, 60, 2)), (0, 1)) for _ in pictures]
    noisy = [np.clip(p + g, 0, 255).astype(np.uint8) for p, g in zip(pictures, rolled, strict=True)]
    return [Frame(i, 0.5 * i, image) for i, image in enumerate(noisy)]


def rotation_and_shift(degrees: float, shift: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    move = cv2.getRotationMatrix2D((340.0, 260.0), degrees, 1.0)
    move[:, 2] += shift
    return move


@pytest.mark.parametrize("noise", [0.5, 3.0, 8.0])
def test_a_still_camera_is_not_said_to_move(noise):
    assert camera_motion_remarks(noisy_frames([pool_picture()] * 6, noise), make_plane()) == ()


def test_shifts_are_found_to_a_tenth_of_a_pixel():
    moved = noisy_frames([pool_picture(), pool_picture(rotation_and_shift(0.0, (3.3, -1.6)))])
    found = corner_shifts(moved, make_plane())
    np.testing.assert_allclose(found[1], np.tile([3.3, -1.6], (4, 1)), atol=0.1)


@pytest.mark.parametrize("move", [rotation_and_shift(0.0, (1.5, 0.5)), rotation_and_shift(0.4)])
def test_a_sudden_motion_is_reported_with_its_time(move):
    reported = camera_motion_remarks(
        noisy_frames([pool_picture()] * 3 + [pool_picture(move)] * 3), make_plane()
    )
    assert len(reported) == 1
    assert "the camera moved by about" in reported[0]
    assert "between 1.00 s and 1.50 s" in reported[0]


def test_a_slow_drift_is_reported_as_stabilisation():
    reported = camera_motion_remarks(
        noisy_frames([pool_picture(rotation_and_shift(0.0, (0.45 * i, 0.0))) for i in range(6)]),
        make_plane(),
    )
    assert len(reported) == 1
    assert "drifts by about 2." in reported[0]


def test_corners_that_do_not_agree_give_no_motion():
    corners = np.array(CORNERS)
    moved = np.zeros((2, 4, 2))
    moved[1] = [[5.0, 0.0], [-4.0, 3.0], [0.0, -6.0], [0.0, 0.0]]
    assert np.isnan(corner_shifts_of_camera_motion(moved, corners)[1]).all()
    moved[1] = [2.0, 1.0]
    np.testing.assert_allclose(
        corner_shifts_of_camera_motion(moved, corners)[1], moved[1], atol=1e-9
    )
    moved[1, 2:] = np.nan
    np.testing.assert_allclose(
        corner_shifts_of_camera_motion(moved, corners)[1], np.tile([2.0, 1.0], (4, 1)), atol=1e-9
    )
