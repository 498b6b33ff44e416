"""Circular fisheye lenses: pictures rendered by an equisolid projection that no model here has."""

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bluekoi.camera.boards import Board, BoardView
from bluekoi.camera.image_circle import ImageCircle, image_circle
from bluekoi.camera.lens import Lens
from bluekoi.camera.lens_bundle_adjustment import fit_lens
from bluekoi.camera.lens_calibration import calibrate_files, camera_yaml, select_lens_model
from bluekoi.camera.lens_selection import lens_implausibilities
from bluekoi.errors import InputError

SIZE, CENTRE, RADIUS = (800, 600), np.array([408.0, 292.0]), 275.0
HALF_FIELD_RAD = np.radians(92)
FOCAL_PX = RADIUS / (2 * np.sin(HALF_FIELD_RAD / 2))
BOARD = Board(9, 6, 0.025)
CIRCLE = ImageCircle((408.0, 292.0), RADIUS)


def random_board_pose(
    rng: np.random.Generator, widest_deg: float = 60.0
) -> tuple[np.ndarray, np.ndarray]:
    """Rotation and translation of a board up to so far from the axis, tilted."""
    off, around = np.radians(rng.uniform(0, widest_deg)), rng.uniform(0, 2 * np.pi)
    toward = np.array([np.sin(off) * np.cos(around), np.sin(off) * np.sin(around), np.cos(off)])
    across = np.cross([0, 1, 0], toward)
    across /= np.linalg.norm(across)
    facing = np.column_stack([across, np.cross(toward, across), toward])
    turn = facing @ Rotation.from_rotvec(rng.uniform(-0.6, 0.6, 3)).as_matrix()
    return turn, rng.uniform(0.13, 0.24) * toward - turn @ BOARD.corners_m.mean(axis=0)


def equisolid_projection(points: np.ndarray) -> np.ndarray:
    """r = 2 f sin(theta / 2)."""
    across = np.hypot(points[:, 0], points[:, 1])
    radius = 2 * FOCAL_PX * np.sin(np.arctan2(across, points[:, 2]) / 2)
    return CENTRE + points[:, :2] * (radius / across)[:, None]


def board_views(n: int, noise_px: float, seed: int, widest_deg: float = 60.0) -> list[BoardView]:
    rng, found = np.random.default_rng(seed), []
    while len(found) < n:
        turn, shift = random_board_pose(rng, widest_deg)
        image = equisolid_projection(BOARD.corners_m @ turn.T + shift)
        if np.hypot(*(image - CENTRE).T).max() < 0.92 * RADIUS:
            noisy = image + rng.normal(0, noise_px, image.shape)
            found.append(BoardView(f"view {len(found)}", BOARD.corners_m, noisy))
    return found


def rendered_board(turn: np.ndarray, shift: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A chessboard before a room, dark outside the image circle."""
    fine = 2
    side = [(np.arange(fine * n) + 0.5) / fine - 0.5 for n in SIZE]
    u, v = np.meshgrid(*side)
    radius, around = (
        np.hypot(u - CENTRE[0], v - CENTRE[1]),
        np.arctan2(v - CENTRE[1], u - CENTRE[0]),
    )
    off = 2 * np.arcsin(np.clip(radius / FOCAL_PX / 2, 0, 1))
    ray = np.stack([np.sin(off) * np.cos(around), np.sin(off) * np.sin(around), np.cos(off)], -1)
    distance = (shift @ turn[:, 2]) / (ray @ turn[:, 2])
    x, y = np.moveaxis((ray * distance[..., None] - shift) @ turn[:, :2] / BOARD.square_m, -1, 0)
    picture = 120 + 30 * np.sin(6 * ray[..., 0])
    picture[(distance > 0) & (abs(x - 4) < 6) & (abs(y - 2.5) < 4.5)] = 215
    squares = (distance > 0) & (abs(x - 4) < 5) & (abs(y - 2.5) < 3.5)
    picture[squares & ((np.floor(x) + np.floor(y)) % 2 == 0)] = 35
    picture[radius > RADIUS] = 6
    small = cv2.resize(picture.astype(np.float32), SIZE, interpolation=cv2.INTER_AREA)
    return np.clip(small + rng.normal(0, 2, small.shape), 0, 255).astype(np.uint8)


def test_a_circular_fisheye_is_calibrated_and_its_image_circle_reported(tmp_path):
    rng = np.random.default_rng(3)
    paths = [tmp_path / f"{i}.png" for i in range(14)]
    for path in paths:
        cv2.imwrite(str(path), rendered_board(*random_board_pose(rng), rng))
    found = calibrate_files(paths, model="fisheye", out=tmp_path / "camera.yaml")
    assert found.circle.center_px == pytest.approx(CENTRE, abs=1.0)
    assert found.circle.radius_px == pytest.approx(RADIUS, abs=1.5)
    assert found.lens.matrix[0, 0] == pytest.approx(FOCAL_PX, rel=0.005)
    assert found.held_out_px < 0.15
    assert found.held_out_px <= 1.02 * found.opencv_px
    section = camera_yaml(found)
    assert "image circle of radius 27" in section
    assert f"(OpenCV: {found.opencv_px:.3f} px)" in section


@pytest.mark.long
def test_all_models_are_compared_on_a_circular_fisheye_and_the_fisheye_is_selected():
    best, _ = select_lens_model(board_views(16, 0.2, 1), "auto", SIZE, CIRCLE)
    assert best.model == "fisheye"
    assert best.held_out_px < 0.33  # 0.2 px noise in each of two directions is 0.28


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.long)])
def test_more_coefficients_never_fit_worse_than_fewer(seed):
    boards = board_views(14, 0.2, seed, widest_deg=75)
    fits = []
    for terms in (4, 5, 8):
        fits.append(fit_lens(boards, "pinhole", terms, SIZE, [fit.lens for fit in fits]))
    errors = [fit.rms_px for fit in fits]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.35


def test_a_projection_that_folds_inside_the_image_circle_is_refused():
    matrix = np.array([[FOCAL_PX, 0, CENTRE[0]], [0, FOCAL_PX, CENTRE[1]], [0, 0, 1]])
    folding = Lens("fisheye", matrix, np.array([-0.2, 0, 0, 0]), SIZE)
    reasons = lens_implausibilities(folding, SIZE, 0.1, CIRCLE)
    assert any("not monotonic inside the image circle" in reason for reason in reasons)
    sound = Lens("fisheye", matrix, np.array([-0.04, 0, 0, 0]), SIZE)
    assert lens_implausibilities(sound, SIZE, 0.1, CIRCLE) == []


def test_the_advice_for_a_circular_fisheye_can_be_followed():
    boards = board_views(16, 0.2, 1)[:5]
    with pytest.raises(InputError, match=r"only 5 views(.|\n)*rim of the image circle") as refused:
        select_lens_model(boards, "fisheye", SIZE, CIRCLE)
    assert "corners of the picture" not in str(refused.value)


def test_pictures_lit_up_to_their_corners_have_no_image_circle():
    u, v = np.meshgrid(*(np.linspace(-1, 1, n) for n in SIZE))
    vignetted = (200 * (1 - 0.3 * (u**2 + v**2))).astype(np.uint8)
    assert image_circle(vignetted) is None
    framed = np.full(SIZE[::-1], 5, np.uint8)
    framed[100:500, 100:700] = 180
    assert image_circle(framed) is None
