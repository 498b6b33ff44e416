"""Corners of the pool from its edges: frames drawn exactly, with and without a second rim."""

from functools import cache

import cv2
import numpy as np
import pytest
from scipy.interpolate import RectBivariateSpline
from scipy.special import ndtr
from test_camera_geometry import LENS, TRUTH

from bluekoi.camera import map_to_pool, pool_to_pixels
from bluekoi.camera.pool_corner_check import pool_corners_picture
from bluekoi.camera.pool_corner_fit import fit_corners
from bluekoi.camera.pool_edge_check import compare_pool_edges
from bluekoi.footage import encode_h264
from bluekoi.stages.pool_edges import check_pool_edges
from bluekoi.study import StudySettings, load_study
from paper_robot import PAPER_ROBOT
from small_studies import edit_trials_csv, small_study

RIM_M = 0.025
SIGMA_PX, PX_PER_M = 1.3, 470.0


@cache
def depth_inside_m() -> np.ndarray:
    """Distance of every pixel's place from the pool's edge, positive inside, by exact optics."""
    width, height = TRUTH.size_px
    u, v = np.arange(0.0, width + 8, 8), np.arange(0.0, height + 8, 8)
    coarse = map_to_pool(TRUTH, np.stack(np.meshgrid(u, v), -1).reshape(-1, 2), 0.0)
    places = coarse.reshape(len(v), len(u), 2)
    x, y = (
        RectBivariateSpline(v, u, places[:, :, k])(np.arange(height), np.arange(width))
        for k in range(2)
    )
    length, across = TRUTH.pool_size_m
    return np.min([x, length - x, y, across - y], axis=0)


def drawn_pool(rim_m: float = 0.0, seed: int = 1) -> np.ndarray:
    """A frame with a bright floor inside a dark surround, and a brighter rim of some width."""
    floor = ndtr(depth_inside_m() * PX_PER_M / SIGMA_PX)
    rim = ndtr((depth_inside_m() + rim_m) * PX_PER_M / SIGMA_PX) - floor
    noise = np.random.default_rng(seed).normal(0, 3, floor.shape)
    return np.clip(60 + 90 * floor + 150 * rim + noise, 0, 255).astype(np.uint8)


def outer_corners() -> np.ndarray:
    signs = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    return pool_to_pixels(TRUTH, TRUTH.corners_m + RIM_M * signs)


def setup_with(corners_px: np.ndarray, *, matrix: bool = True) -> StudySettings:
    camera = {
        "model": "pinhole",
        "image_size_px": (1920, 1080),
        "matrix": LENS.matrix.tolist(),
        "distortion": LENS.distortion.tolist(),
        "pool_corners_px": corners_px.tolist(),
    }
    if not matrix:
        camera = {k: v for k, v in camera.items() if k not in ("matrix", "distortion")}
    return StudySettings.model_validate({"robot": PAPER_ROBOT, "camera": camera})


def corner_errors_px(found_px: np.ndarray) -> np.ndarray:
    return np.linalg.norm(found_px - TRUTH.corners_px, axis=1)


@pytest.mark.parametrize("lens", [LENS, None], ids=["with a matrix", "without"])
@pytest.mark.parametrize("rim_m", [0.0, RIM_M], ids=["one rim", "two rims"])
@pytest.mark.parametrize("corner", [0, pytest.param(2, marks=pytest.mark.long)])
def test_one_corner_31_px_off_is_put_right_in_one_run(lens, rim_m, corner):
    given = TRUTH.corners_px.copy()
    given[corner] += [25.0, -18.0]
    found = fit_corners(drawn_pool(rim_m=rim_m), given, lens)
    assert found.converged
    assert found.doubts == ()
    assert corner_errors_px(found.corners_px).max() < (0.4 if lens else 1.2)
    assert (found.outer_px > 0) == (rim_m > 0)


def test_corners_3_px_off_converge_without_a_camera_matrix():
    given = TRUTH.corners_px + np.random.default_rng(5).normal(0, 3, (4, 2))
    found = fit_corners(drawn_pool(rim_m=RIM_M), given, None)
    assert found.converged
    assert corner_errors_px(found.corners_px).max() < 1.2


def test_stated_deviations_of_the_corners_hold():
    errors = []
    for seed in range(4):
        given = TRUTH.corners_px + np.random.default_rng(seed).normal(0, 4, (4, 2))
        found = fit_corners(drawn_pool(seed=seed), given, LENS)
        errors.append((found.corners_px - TRUTH.corners_px) / found.std_px[:, None])
    assert 0.4 < np.sqrt(np.mean(np.square(errors))) < 1.3


def test_corners_given_on_the_outer_rim_are_not_certain_and_the_inner_one_is_suggested(tmp_path):
    given = outer_corners()
    found = fit_corners(drawn_pool(rim_m=RIM_M), given, LENS)
    assert "two rims" in found.doubts[0]
    assert corner_errors_px(found.inner_rim_px).max() < 0.5
    check = pool_corners_picture(drawn_pool(rim_m=RIM_M), setup_with(given), tmp_path / "pool.png")
    assert not check.confirmed
    assert any("# the inner rim" in line for line in check.sentences)


def test_corners_in_their_place_are_confirmed(tmp_path):
    given = setup_with(TRUTH.corners_px)
    check = pool_corners_picture(drawn_pool(), given, tmp_path / "pool.png")
    assert check.confirmed
    assert corner_errors_px(check.suggested_px).max() < 0.5
    assert "miss the best pose by 0.0" in check.sentences[0]
    assert (tmp_path / "pool.png").stat().st_size > 10_000


def test_a_wrong_corner_is_named_and_the_corners_found_are_suggested(tmp_path):
    given = TRUTH.corners_px.copy()
    given[2] += [-12, 9]
    check = pool_corners_picture(drawn_pool(), setup_with(given), tmp_path / "pool.png")
    assert not check.confirmed
    assert "corner (length, width) lies 15" in " ".join(check.sentences)
    assert any(line.startswith("pool_corners_px: [[") for line in check.sentences)


def test_without_a_camera_matrix_no_pose_error_is_stated(tmp_path):
    setup = setup_with(TRUTH.corners_px, matrix=False)
    check = pool_corners_picture(drawn_pool(), setup, tmp_path / "pool.png")
    assert not any("best pose" in line for line in check.sentences)
    assert check.confirmed


def test_a_frame_without_edges_confirms_nothing(tmp_path):
    blank = np.full((1080, 1920), 90, np.uint8)
    check = pool_corners_picture(blank, setup_with(TRUTH.corners_px), tmp_path / "pool.png")
    assert not check.confirmed
    assert sum("no straight step" in line for line in check.sentences) == 4


def test_corners_that_fit_no_camera_are_drawn_with_the_reason(tmp_path):
    rolled = np.roll(TRUTH.corners_px, 1, axis=0)
    found = pool_corners_picture(drawn_pool(), setup_with(rolled), tmp_path / "pool.png")
    assert "begin with the corner now listed second" in found.sentences[0]
    assert not found.confirmed
    assert (tmp_path / "pool.png").exists()


def test_a_camera_displaced_by_7_cm_is_noticed():
    off_px = 0.07 * PX_PER_M
    shift = np.array([[1.0, 0, off_px], [0, 1.0, 0]])
    moved = cv2.warpAffine(drawn_pool(RIM_M), shift, (1920, 1080), borderMode=cv2.BORDER_REPLICATE)
    found = compare_pool_edges(moved, setup_with(TRUTH.corners_px))
    assert found.moved
    assert not found.turned
    assert found.off_px == pytest.approx(off_px, abs=1.0)
    assert "was the camera moved" in found.remarks[0]


def test_a_recording_turned_by_180_degrees_is_noticed():
    found = compare_pool_edges(drawn_pool(RIM_M)[::-1, ::-1].copy(), setup_with(TRUTH.corners_px))
    assert found.turned
    assert "turned by 180 degrees" in found.remarks[0]


@pytest.mark.parametrize("matrix", [True, False], ids=["with a matrix", "without"])
def test_a_camera_in_its_place_gets_no_warning_whatever_the_clicks(matrix):
    clicked = TRUTH.corners_px + np.random.default_rng(3).uniform(-2, 2, (4, 2))
    found = compare_pool_edges(drawn_pool(RIM_M), setup_with(clicked, matrix=matrix))
    assert (found.found, found.remarks) == (4, ())


def test_a_frame_without_edges_gets_no_warning():
    found = compare_pool_edges(np.full((1080, 1920), 90, np.uint8), setup_with(TRUTH.corners_px))
    assert (found.off_px, found.remarks) == (None, ())


def test_a_trials_status_says_where_its_recording_has_the_pools_edges(tmp_path):
    study = small_study(tmp_path / "study")
    shift = np.array([[1.0, 0, 40.0], [0, 1.0, 0]])
    frame = cv2.warpAffine(drawn_pool(), shift, (1920, 1080), borderMode=cv2.BORDER_REPLICATE)
    (study / "videos").mkdir()
    encode_h264(study / "videos/T10.mp4", [np.dstack([frame] * 3)] * 3, fps=30, size=(1920, 1080))
    edit_trials_csv(study, T10={"source": "videos/T10.mp4", "fps": ""})
    loaded = load_study(study).model_copy(update={"setup": setup_with(TRUTH.corners_px)})
    found, remarks = check_pool_edges(loaded, loaded.trial("T10"))
    assert found["off_px"] == pytest.approx(40, abs=1)
    assert "bluekoi pool" in remarks[0]
    assert "--trial T10" in remarks[0]
    assert check_pool_edges(loaded, loaded.trial("T09")) == (None, ())
