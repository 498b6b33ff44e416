"""Calibration on rendered and recorded boards: bars, refusals, stated uncertainty."""

import json

import cv2
import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from bluekoi.camera.boards import Board, BoardView, board_from_pattern, find_board
from bluekoi.camera.focal_length_groups import zoom_change_remark
from bluekoi.camera.gyroflow_profile import read_lens_profile
from bluekoi.camera.lens import Lens, lens_parameters, project_to_pixels
from bluekoi.camera.lens_bundle_adjustment import fit_lens
from bluekoi.camera.lens_calibration import (
    calibrate_files,
    calibration_from_lens_profile,
    camera_yaml,
    select_lens_model,
)
from bluekoi.camera.lens_selection import MODELS_COMPARED, fit_lens_candidate, select_lens
from bluekoi.errors import InputError

IMAGE_SIZE_PX = (640, 480)
BOARD = Board(9, 6, 0.025)
PINHOLE = Lens("pinhole", np.array([[520.0, 0, 322], [0, 521, 236], [0, 0, 1]]),
               np.array([-0.25, 0.08, 0.0005, -0.0005]), IMAGE_SIZE_PX)  # fmt: skip
FISHEYE = Lens("fisheye", np.array([[300.0, 0, 322], [0, 301, 236], [0, 0, 1]]),
               np.array([0.03, 0.02, -0.01, 0.002]), IMAGE_SIZE_PX)  # fmt: skip


def poses(n: int, rng: np.random.Generator, tilt: float = 0.6, near: float = 0.3) -> np.ndarray:
    turns = rng.uniform([-tilt, -tilt, -0.3], [tilt, tilt, 0.3], (n, 3))
    places = rng.uniform([-0.2, -0.15, near], [0.0, 0.03, near * 1.7], (n, 3))
    return np.column_stack([turns, places])


def board_views(lens: Lens, where: np.ndarray, noise_px: float, rng: np.random.Generator):
    found = []
    for i, pose in enumerate(where):
        seen = BOARD.corners_m @ Rotation.from_rotvec(pose[:3]).as_matrix().T + pose[3:]
        image = project_to_pixels(lens, seen)
        inside = np.all((image > 0) & (image < np.array(IMAGE_SIZE_PX)), axis=1)
        if inside.sum() >= 20:
            noisy = image[inside] + rng.normal(0, noise_px, (int(inside.sum()), 2))
            found.append(BoardView(f"view {i}", BOARD.corners_m[inside], noisy))
    return found


def warped_board(flat: np.ndarray, px_per_m: float, pose: np.ndarray) -> np.ndarray:
    """A flat board's picture seen by a camera with focal length 500 px and no distortion."""
    matrix = np.array([[500.0, 0, 319.5], [0, 500, 239.5], [0, 0, 1]])
    turn = Rotation.from_rotvec(pose[:3]).as_matrix()
    to_m = np.diag([1 / px_per_m, 1 / px_per_m, 1])
    whole = matrix @ np.column_stack([turn[:, 0], turn[:, 1], pose[3:]]) @ to_m
    large = cv2.warpPerspective(
        flat, np.diag([3, 3, 1]) @ whole, (1920, 1440), flags=cv2.INTER_AREA, borderValue=200
    )
    return cv2.resize(large, IMAGE_SIZE_PX, interpolation=cv2.INTER_AREA)


def chessboard_picture() -> tuple[np.ndarray, float]:
    squares = np.indices((7, 10)).sum(axis=0) % 2
    flat = np.kron(np.where(squares == 0, 30, 220), np.ones((80, 80))).astype(np.uint8)
    return cv2.copyMakeBorder(flat, 80, 80, 80, 80, cv2.BORDER_CONSTANT, value=220), 80 / 0.025


def board_poses(n: int, seed: int = 4) -> np.ndarray:
    rng = np.random.default_rng(seed)
    turns = rng.uniform([-0.6, -0.6, -0.2], [0.6, 0.6, 0.2], (n, 3))
    places = rng.uniform([-0.19, -0.15, 0.34], [-0.1, -0.08, 0.45], (n, 3))
    return np.column_stack([turns, places])


@pytest.mark.parametrize("lens", [PINHOLE, FISHEYE], ids=["pinhole", "fisheye"])
def test_exact_corners_give_the_lens_back(lens):
    rng = np.random.default_rng(2)
    views = board_views(lens, poses(14, rng), 0.0, rng)
    fit = fit_lens(views, lens.model, 4, IMAGE_SIZE_PX)
    assert fit.rms_px < 1e-5
    assert np.allclose(lens_parameters(fit.lens)[:4], lens_parameters(lens)[:4], atol=1e-2)


def test_lens_uncertainty_is_of_the_right_width():
    pulls = []
    for seed in range(10):
        rng = np.random.default_rng(100 + seed)
        views = board_views(PINHOLE, poses(20, rng), 0.2, rng)
        fit = fit_lens(views, "pinhole", 4, IMAGE_SIZE_PX)
        miss = lens_parameters(fit.lens) - lens_parameters(PINHOLE)
        pulls.append(miss / np.sqrt(np.diag(fit.lens_cov)))
    width = float(np.sqrt(np.mean(np.square(pulls))))
    assert 0.8 < width < 1.3, width


@pytest.mark.long
def test_the_model_is_chosen_by_views_held_out():
    rng = np.random.default_rng(6)
    wide = board_views(FISHEYE, poses(14, rng, near=0.12), 0.15, rng)
    best, tried = select_lens_model(wide, "auto", IMAGE_SIZE_PX)
    assert best.model == "fisheye"
    assert len(tried) == len(MODELS_COMPARED)
    narrow = board_views(PINHOLE, poses(11, rng), 0.15, rng)
    best, _ = select_lens_model(narrow, "pinhole", IMAGE_SIZE_PX)
    assert (best.model, best.terms) == ("pinhole", 4)
    assert best.held_out_px < 1.2 * best.fit.rms_px


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ("few", "only 7 views"),
        ("frontal", "boards are seen frontally"),
        ("stretched", "more than 5 % apart"),
        ("cropped", "off the middle"),
        ("noisy", "px rms, more than"),
    ],
)
def test_calibrations_that_cannot_be_right_are_refused_with_the_reason(change, reason):
    rng = np.random.default_rng(9)
    where = poses(7 if change == "few" else 14, rng, tilt=0.05 if change == "frontal" else 0.6)
    lens = PINHOLE
    if change in ("stretched", "cropped"):
        matrix = PINHOLE.matrix.copy()
        matrix[0, 0] *= 1.1 if change == "stretched" else 1
        matrix[0, 2] -= 90 if change == "cropped" else 0
        lens = Lens("pinhole", matrix, PINHOLE.distortion, IMAGE_SIZE_PX)
    views = board_views(lens, where, 3.0 if change == "noisy" else 0.1, rng)
    found = fit_lens_candidate(views, "pinhole", 4, IMAGE_SIZE_PX)
    assert any(reason in words for words in found.implausibilities)
    assert select_lens([found]) is None


def test_a_refused_calibration_names_its_reasons_and_the_cure():
    rng = np.random.default_rng(9)
    views = board_views(PINHOLE, poses(9, rng, tilt=0.05), 0.1, rng)
    with pytest.raises(InputError, match=r"frontally: 0 of 9(.|\n)*tilted by 20 to 45 degrees"):
        select_lens_model(views, "pinhole", IMAGE_SIZE_PX)


def test_a_lens_that_folds_inside_the_picture_is_refused():
    rng = np.random.default_rng(10)
    lens = Lens("pinhole", PINHOLE.matrix, np.array([-0.55, 0, 0, 0.0]), IMAGE_SIZE_PX)
    middle = poses(16, rng, near=0.6)
    middle[:, 3:5] = rng.uniform([-0.12, -0.08], [-0.08, -0.05], (16, 2))
    found = fit_lens_candidate(board_views(lens, middle, 0.05, rng), "pinhole", 4, IMAGE_SIZE_PX)
    assert any("not monotonic inside the picture" in reason for reason in found.implausibilities)


@pytest.mark.parametrize("seed", range(3))
def test_two_zooms_in_one_set_are_reported(seed):
    """Eight of twenty views through a lens of six per cent more focal length."""
    rng = np.random.default_rng(900 + seed)
    longer = Lens(
        "pinhole", np.diag([1.06, 1.06, 1]) @ PINHOLE.matrix, PINHOLE.distortion, IMAGE_SIZE_PX
    )
    longer.matrix[:2, 2] = PINHOLE.matrix[:2, 2]
    where = poses(20, rng)
    views = board_views(PINHOLE, where[:12], 0.2, rng) + board_views(longer, where[12:], 0.2, rng)
    found = fit_lens_candidate(views, "pinhole", 4, IMAGE_SIZE_PX)
    assert "two focal lengths" in zoom_change_remark(found.fit, list(found.views))


@pytest.mark.parametrize("seed", range(8))
def test_one_zoom_is_not_taken_for_two(seed):
    rng = np.random.default_rng(100 + seed)
    found = fit_lens_candidate(
        board_views(PINHOLE, poses(14, rng), 0.3, rng), "pinhole", 4, IMAGE_SIZE_PX
    )
    assert zoom_change_remark(found.fit, list(found.views)) == ""


def test_a_view_grossly_off_is_left_out_and_named():
    rng = np.random.default_rng(12)
    views = board_views(PINHOLE, poses(15, rng), 0.15, rng)
    spoilt = views[3].image_px + rng.normal(0, 6, views[3].image_px.shape)
    views[3] = BoardView("shaken", views[3].board_m, spoilt)
    best = fit_lens_candidate(views, "pinhole", 4, IMAGE_SIZE_PX)
    assert len(best.left_out) == 1
    assert "shaken" in best.left_out[0]


def test_photographs_in_camera_yaml_and_picture_out(tmp_path):
    flat, scale = chessboard_picture()
    paths = []
    for i, pose in enumerate(board_poses(12)):
        path = tmp_path / f"board {i:02d}.png"
        path.write_bytes(cv2.imencode(".png", warped_board(flat, scale, pose))[1].tobytes())
        paths.append(path)
    result = calibrate_files(paths, pattern="9x6", model="pinhole", out=tmp_path / "camera.yaml")
    assert result.rms_px < 0.1
    assert abs(result.lens.matrix[0, 0] - 500) < 4 * result.lens_std[0] + 0.5
    section = yaml.safe_load((tmp_path / "camera.yaml").read_text())["camera"]
    assert section["image_size_px"] == [640, 480]
    assert np.allclose(section["matrix"], result.lens.matrix, rtol=1e-5)
    assert (tmp_path / "camera.png").stat().st_size > 10_000


@pytest.fixture
def board_photographs(tmp_path):
    flat, scale = chessboard_picture()
    paths = [tmp_path / f"{i}.png" for i in range(12)]
    for path, pose in zip(paths, board_poses(12), strict=True):
        cv2.imwrite(str(path), warped_board(flat, scale, pose))
    return paths


@pytest.mark.parametrize("name", ["camera.yaml", "camera.png"])
def test_a_folder_in_the_place_of_a_result_leaves_nothing(board_photographs, tmp_path, name):
    (tmp_path / name).mkdir()
    before = sorted(tmp_path.iterdir())
    with pytest.raises(InputError, match=f"{name}: --out: found a folder"):
        calibrate_files(board_photographs, model="pinhole", out=tmp_path / "camera.yaml")
    assert sorted(tmp_path.iterdir()) == before


def test_a_picture_that_cannot_be_drawn_leaves_no_camera_section(
    board_photographs, tmp_path, monkeypatch
):
    def no_room(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("bluekoi.camera.lens_calibration.draw_calibration", no_room)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(InputError, match="No space left"):
        calibrate_files(board_photographs, model="pinhole", out=tmp_path / "camera.yaml")
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(("count", "found"), [(1, "only 1 view;"), (3, "only 3 views;")])
def test_too_few_photographs_are_one_message(board_photographs, tmp_path, count, found):
    with pytest.raises(InputError) as caught:
        calibrate_files(board_photographs[:count], out=tmp_path / "camera.yaml")
    (finding,) = caught.value.findings
    assert finding.found == f"{found} at least 8 are needed"
    assert "Take 15 or more pictures" in finding.remedy


def test_a_video_is_as_good_as_photographs(tmp_path):
    flat, scale = chessboard_picture()
    path = tmp_path / "board.avi"
    video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 30.0, IMAGE_SIZE_PX)
    for pose in board_poses(12):
        grey = warped_board(flat, scale, pose)
        for _ in range(3):
            video.write(np.repeat(grey[:, :, None], 3, axis=2))
    video.release()
    result = calibrate_files([path], pattern="9x6", model="pinhole", out=tmp_path / "c.yaml")
    assert result.views <= 13
    assert abs(result.lens.matrix[0, 0] - 500) < 4 * result.lens_std[0] + 1


def test_a_video_without_the_board_is_given_up_after_a_first_look(tmp_path):
    path = tmp_path / "pool.avi"
    video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 30.0, IMAGE_SIZE_PX)
    for _ in range(160):
        video.write(np.full((IMAGE_SIZE_PX[1], IMAGE_SIZE_PX[0], 3), 90, dtype=np.uint8))
    video.release()
    with pytest.raises(InputError, match=r"1[0-6] pictures, none with the whole board"):
        calibrate_files([path], pattern="9x6", out=tmp_path / "c.yaml")


@pytest.mark.long
def test_charuco_boards_may_be_partly_out_of_view(tmp_path):
    markers = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_250)
    drawn = cv2.aruco.CharucoBoard((10, 7), 0.025, 0.01875, markers)
    flat = drawn.generateImage((800, 560))
    paths, whole = [], []
    for i, pose in enumerate(board_poses(14, seed=5)):
        pose[3:5] -= [0.05, 0.04]
        grey = warped_board(flat, 80 / 0.025, pose)
        paths.append(tmp_path / f"{i}.png")
        cv2.imwrite(str(paths[-1]), grey)
        whole += [find_board(grey, board_from_pattern("9x6", 25, "charuco"), "x")] if i < 6 else []
    assert any(view is not None and len(view.board_m) < 54 for view in whole)
    out = tmp_path / "camera.yaml"
    result = calibrate_files(paths, pattern="9x6", board="charuco", model="pinhole", out=out)
    assert abs(result.lens.matrix[0, 0] - 500) < 4 * result.lens_std[0] + 1


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"pattern": "nine"}, "inner corners across x down"),
        ({"square_mm": 0.0}, "side of a square"),
        ({"board": "dots"}, "one of chessboard, charuco"),
        ({}, "no picture"),
    ],
)
def test_wrong_options_and_files_are_reported(tmp_path, given, reason):
    path = tmp_path / "notes.jpg"
    path.write_text("not a picture")
    with pytest.raises(InputError, match=reason):
        calibrate_files([path], out=tmp_path / "c.yaml", **given)
    assert not (tmp_path / "c.yaml").exists()


def test_pictures_without_a_board_say_count_inner_corners(tmp_path):
    path = tmp_path / "grey.png"
    path.write_bytes(cv2.imencode(".png", np.full((480, 640), 90, np.uint8))[1].tobytes())
    with pytest.raises(InputError, match="Count inner corners"):
        calibrate_files([path], out=tmp_path / "c.yaml")


@pytest.mark.recordings
def test_opencv_left_set_published_0_393_px(recordings, tmp_path):
    images = sorted((recordings / "chessboard").glob("left*.jpg"))
    result = calibrate_files(images, pattern="9x6", out=tmp_path / "camera.yaml")
    assert result.views == 13
    assert result.rms_px <= 0.20
    assert result.held_out_px <= 1.2 * 0.20


@pytest.mark.recordings
def test_gopro_set_fisheye_0_43_px(recordings, tmp_path):
    images = sorted((recordings / "gopro_chessboard").glob("*.jpg"))
    result = calibrate_files(images, pattern="8x6", model="fisheye", out=tmp_path / "camera.yaml")
    assert result.views == 35
    assert result.rms_px <= 0.43
    assert result.held_out_px <= 1.2 * 0.43
    assert "2 pictures" in result.remarks[0]


@pytest.mark.recordings
def test_hero11_profiles_become_the_same_camera_section(recordings, tmp_path):
    folder = recordings / "lens_profiles"
    for path in sorted(folder.glob("*.json")):
        calibrate_files([path], out=tmp_path / "camera.yaml")
        section = yaml.safe_load((tmp_path / "camera.yaml").read_text())["camera"]
        assert section["model"] == "fisheye"
        assert len(section["distortion"]) == 4
    wide = folder / "GoPro_HERO11 Black_Wide_16by9.json"
    lens, rms, count = read_lens_profile(wide)
    assert lens.matrix[0, 0] == pytest.approx(1796.32, abs=0.02)
    assert (lens.size_px, count) == ((3840, 2160), 30)
    assert rms == pytest.approx(0.2668, abs=2e-3)


def test_stretched_lens_modes_and_other_json_are_refused(tmp_path):
    good = {
        "lens_model": "HyperView",
        "calib_dimension": {"w": 64, "h": 48},
        "fisheye_params": {
            "camera_matrix": [[30, 0, 32], [0, 30, 24], [0, 0, 1]],
            "distortion_coeffs": [0, 0, 0, 0],
        },
    }
    path = tmp_path / "lens.json"
    path.write_text(json.dumps(good))
    with pytest.raises(InputError, match="lens mode hyperview"):
        read_lens_profile(path)
    path.write_text("{}")
    with pytest.raises(InputError, match="not a lens profile"):
        read_lens_profile(path)


def test_a_profile_is_of_a_fisheye_whatever_is_asked(tmp_path):
    with pytest.raises(InputError, match="lens profiles are"):
        calibrate_files([tmp_path / "lens.json"], model="pinhole", out=tmp_path / "camera.yaml")
    assert not (tmp_path / "camera.yaml").exists()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"camera_matrix": [[float("nan"), 0, 32], [0, 30, 24], [0, 0, 1]]}, "not all numbers"),
        ({"camera_matrix": [[-30, 0, 32], [0, 30, 24], [0, 0, 1]]}, "not above 0"),
        ({"camera_matrix": [[30, 0, 3], [0, 30, 24], [0, 0, 1]]}, "optical centre"),
        ({"distortion_coeffs": [-2, 0, 0, 0]}, "folds over"),
        ({"RMS_error": 35}, "corners miss by 35"),
        ({"distortion_coeffs": [1, 2]}, "distortion_coeffs has 4 numbers"),
    ],
)
def test_a_profile_that_cannot_be_right_is_refused(tmp_path, change, words):
    lens = {
        "camera_matrix": [[30, 0, 32], [0, 30, 24], [0, 0, 1]],
        "distortion_coeffs": [0, 0, 0, 0],
    }
    path = tmp_path / "lens.json"
    content = {"calib_dimension": {"w": 64, "h": 48}, "fisheye_params": lens}
    path.write_text(json.dumps(content))
    assert "nan" not in camera_yaml(calibration_from_lens_profile(path))
    path.write_text(json.dumps(content | {"fisheye_params": lens | change}))
    with pytest.raises(InputError, match=words):
        read_lens_profile(path)
