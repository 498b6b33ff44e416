"""Why no robot was found: each reason has its numbers and its remedy."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from bluekoi.keypoints import NO_ROBOT_REMARK
from bluekoi.keypoints.outline.plane import SwimmingPlaneMap
from bluekoi.keypoints.outline.robot_not_found import robot_not_found_reason
from bluekoi.stages import tracks

CORNERS = np.array([[10.0, 290.0], [390.0, 290.0], [390.0, 10.0], [10.0, 10.0]])


def make_plane(px_per_bl: float) -> SwimmingPlaneMap:
    nothing = np.zeros((2, 2, 2))
    return SwimmingPlaneMap(
        nothing, nothing, np.zeros((2, 2)), np.zeros((2, 2)), CORNERS, px_per_bl
    )


def pictures_of_bodies(bodies: int, contrast: int = 80, half_px: tuple[int, int] = (40, 7)):
    """Five pictures of bodies that move from one to the next, on a noisy floor."""
    rng = np.random.default_rng(3)
    for k in range(5):
        image = rng.normal(150, 2, (300, 400))
        for body in range(bodies):
            shape = np.zeros_like(image)
            cv2.ellipse(shape, (70 + 60 * k, 60 + 90 * body), half_px, 0, 0, 360, 1.0, -1)
            image -= contrast * shape
        yield np.clip(image, 0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    ("seen", "px_per_bl", "words"),
    [
        ((1, 80), 30.0, ("the robot is 30 px long", "at least 40", "film from nearer")),
        ((1, 0), 80.0, ("nothing differs from the background", "grey levels", "must move")),
        ((1, 80), 250.0, ("the largest thing that moves is 8", "250 px", "body_length_m")),
        ((3, 80), 80.0, ("3 bodies of about the stated 80 px", "start_x_px")),
        ((1, 80), 80.0, ("a thing of about the stated 80 px", "head_length_m", "bending")),
    ],
    ids=["too small", "no contrast", "another size", "several bodies", "another shape"],
)
def test_the_reason_names_size_contrast_number_or_shape(seen, px_per_bl, words):
    text = robot_not_found_reason(
        list(pictures_of_bodies(*seen)), make_plane(px_per_bl), 1.0, bending=False
    )
    assert all(word in text for word in words), text


def test_moving_light_is_named_as_a_reason():
    """Patches of all sizes, a few of them as long as the robot, in an empty pool."""
    rng = np.random.default_rng(5)
    pictures = []
    for _ in range(5):
        image = rng.normal(150, 2, (300, 400)).astype(np.float32)
        for _ in range(40):
            patch, axes = np.zeros_like(image), rng.uniform(2, 45, 2) / [1, 6]
            place = rng.uniform([20, 20], [380, 280]).astype(int).tolist()
            cv2.ellipse(patch, place, axes.astype(int).tolist(), rng.uniform(0, 180), 0, 360, 1, -1)
            image += 30 * patch
        pictures.append(np.clip(image, 0, 255).astype(np.uint8))
    text = robot_not_found_reason(pictures, make_plane(60.0), 1.0, bending=False)
    assert "about as long as the robot (60 px)" in text
    assert "moving light or reflections, is the robot in the picture?" in text


def test_robots_beside_specks_still_get_the_remedy_for_several_robots():
    pictures = list(pictures_of_bodies(2))
    for frame, image in enumerate(pictures):
        for k in range(5):
            cv2.circle(image, (40 + 70 * k, 220 + 10 * frame), 4, 230, -1)
    text = robot_not_found_reason(pictures, make_plane(80.0), 1.0, bending=False)
    assert "2 of them about as long as the robot" in text
    assert "start_x_px" in text


def test_a_bending_body_is_not_advised_to_be_declared_bending():
    text = robot_not_found_reason(list(pictures_of_bodies(1)), make_plane(80.0), 1.0, bending=True)
    assert "midline" in text
    assert "detection.body" not in text


def test_a_trial_without_a_robot_is_refused_with_the_reason_of_the_detector():
    study = SimpleNamespace(root=Path("lab"), paths=lambda _: [Path("lab/T1.mp4")])
    trial = SimpleNamespace(trial_id="T1")
    error = tracks._no_robot_error(study, trial, [f"{NO_ROBOT_REMARK}nothing moves", "other"])
    assert "trial T1: found no robot by the detector (nothing moves)" in str(error)
    assert "`bluekoi setup lab`" in str(error)
    assert tracks._no_robot_error(study, trial, ["7 of 9 frames without the robot"]) is None
