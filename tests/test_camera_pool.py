"""Pose from corners, refraction both ways, covariance, and the message for a wrong study."""

import json

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bluekoi.camera import (
    Lens,
    PoolCamera,
    camera_from_corners,
    map_keypoints,
    map_to_pool,
    pixel_to_pool_jacobian,
    pool_camera,
    pool_to_pixels,
)
from bluekoi.camera.refraction import horizontal_air_path_share, refract_rays
from bluekoi.camera.resection import pool_rectangle
from bluekoi.data import Keypoints
from bluekoi.errors import InputError
from bluekoi.study import StudySettings
from bluekoi.study.recording_pixels import setup_in_recording_pixels, to_study_pixels
from paper_robot import PAPER_ROBOT

MATRIX = [[1130.0, 0.0, 955.0], [0.0, 1130.0, 542.0], [0.0, 0.0, 1.0]]
LENS = Lens("pinhole", np.array(MATRIX), np.array([-0.12, 0.03, 0.0004, -0.0003, 0]), (1920, 1080))
CORNERS_M = pool_rectangle(2.6, 1.6, 0.0)


def overhead_camera(lens: Lens = LENS, height_m: float = 2.3, tilt: float = 0.05) -> PoolCamera:
    """A camera above the pool's middle whose corner images are exact."""
    c, s = np.cos(tilt), np.sin(tilt)
    turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ np.diag([1.0, -1.0, -1.0])
    shift = -turn @ np.array([1.25, 0.85, height_m])
    blank = np.zeros((4, 2))
    camera = PoolCamera(
        size_px=lens.size_px,
        corners_px=blank,
        corners_m=CORNERS_M,
        refractive_index=1.333,
        residuals_px=blank,
        corner_std_px=1.0,
        lens=lens,
        rotation=turn,
        translation=shift,
    )
    return PoolCamera(**{**camera.__dict__, "corners_px": pool_to_pixels(camera, CORNERS_M)})


def setup_for(camera: PoolCamera, **changes) -> StudySettings:
    section = {
        "model": camera.lens.model,
        "image_size_px": camera.size_px,
        "matrix": camera.lens.matrix.tolist(),
        "distortion": camera.lens.distortion.tolist(),
        "pool_corners_px": camera.corners_px.tolist(),
    } | changes
    return StudySettings.model_validate({"robot": PAPER_ROBOT, "camera": section})


def pool_points(n: int = 60) -> np.ndarray:
    rng = np.random.default_rng(3)
    return rng.uniform([0.05, 0.05], [2.55, 1.55], (n, 2))


@pytest.mark.recordings
def test_refraction_oracle_aquacal(recordings):
    folder = recordings / "refraction"
    config = json.loads((folder / "oracle_config.json").read_text())
    table = pd.read_csv(folder / "oracle_projection.csv")
    flip = np.diag([1.0, -1.0, -1.0])
    turn = np.array(config["R_world_to_cam"])
    blank = np.zeros((4, 2))
    camera = PoolCamera(
        size_px=tuple(config["image"]),
        corners_px=blank,
        corners_m=CORNERS_M,
        refractive_index=config["n_water"],
        residuals_px=blank,
        corner_std_px=1.0,
        lens=Lens("pinhole", np.array(config["K"]), np.zeros(5), tuple(config["image"])),
        rotation=turn @ flip,
        translation=turn @ [0, 0, config["water_z_m"]] + np.array(config["t"]),
    )
    xy = np.column_stack([table.X_m, -table.Y_m])
    image = table[["u_refracted_px", "v_refracted_px"]].to_numpy()
    assert np.abs(map_to_pool(camera, image, table.depth_m.to_numpy()) - xy).max() < 1e-6
    seen = pool_to_pixels(camera, np.column_stack([xy, -table.depth_m]))
    assert np.abs(seen - image).max() < 1e-6
    dry = PoolCamera(**{**camera.__dict__, "refractive_index": 1.0})
    straight = table[["u_no_refraction_px", "v_no_refraction_px"]].to_numpy()
    assert (
        np.abs(pool_to_pixels(dry, np.column_stack([xy, -table.depth_m])) - straight).max() < 1e-6
    )


def test_readme_claim_25_mm_at_the_corner_from_2_m_up():
    camera = overhead_camera(height_m=2.0, tilt=0.0)
    corner = np.array([[0.0, 0.0]])
    image = pool_to_pixels(camera, np.column_stack([corner, [[-0.05]]]))
    ignored = map_to_pool(camera, image, 0.0) - corner
    assert np.linalg.norm(ignored) == pytest.approx(0.025, abs=0.004)


@settings(max_examples=60, deadline=None)
@given(
    x=st.floats(0.0, 2.6),
    y=st.floats(0.0, 1.6),
    z=st.floats(-0.3, 0.2),
    height=st.floats(1.0, 4.0),
    tilt=st.floats(-0.2, 0.2),
)
def test_project_and_to_pool_are_inverse(x, y, z, height, tilt):
    wide = Lens("fisheye", np.array(MATRIX), np.array([0.03, 0.06, -0.07, 0.03]), (1920, 1080))
    camera = overhead_camera(wide, height, tilt)
    image = pool_to_pixels(camera, np.array([[x, y, z]]))
    assert np.allclose(map_to_pool(camera, image, -z), [[x, y]], atol=1e-8)


def test_snell_holds_on_both_sides_of_the_surface():
    angle = np.linspace(0, 1.4, 20)
    rays = np.column_stack([np.sin(angle), np.zeros(20), -np.cos(angle)])
    bent = refract_rays(rays, 1.333)
    assert np.allclose(np.linalg.norm(bent, axis=1), 1)
    assert np.allclose(1.333 * bent[:, 0], rays[:, 0])
    share = horizontal_air_path_share(np.array([1.5]), 2.0, np.array([0.3]), 1.333)[0]
    air, water = 1.5 * share, 1.5 * (1 - share)
    assert air / np.hypot(air, 2) == pytest.approx(1.333 * water / np.hypot(water, 0.3), rel=1e-13)


def test_pose_comes_back_from_exact_corners():
    truth = overhead_camera()
    found = pool_camera(setup_for(truth))
    assert np.allclose(found.center_m, truth.center_m, atol=1e-7)
    assert found.rms_px < 1e-6
    xyz = np.column_stack([pool_points(), np.full(60, -0.04)])
    assert np.allclose(map_to_pool(found, pool_to_pixels(truth, xyz), 0.04), xyz[:, :2], atol=1e-7)


def test_marks_above_the_water_are_placed_there():
    truth = overhead_camera()
    raised = pool_rectangle(2.6, 1.6, 0.12)
    marks = pool_to_pixels(truth, raised).tolist()
    found = pool_camera(setup_for(truth, pool_corners_px=marks, pool_corners_height_m=0.12))
    assert np.allclose(found.center_m, truth.center_m, atol=1e-6)
    ignored = pool_camera(setup_for(truth, pool_corners_px=marks))
    assert abs(ignored.center_m[2] - truth.center_m[2]) > 0.1


def test_recording_scaled_alike_is_followed_and_another_shape_refused():
    truth = overhead_camera()
    twice = pool_camera(setup_for(truth), size_px=(3840, 2160))
    xyz = np.column_stack([pool_points(), np.full(60, -0.04)])
    assert np.allclose(
        map_to_pool(twice, pool_to_pixels(truth, xyz) * 2 + 0.5, 0.04), xyz[:, :2], atol=1e-6
    )
    with pytest.raises(InputError, match="turned by 90 degrees"):
        pool_camera(setup_for(truth), size_px=(1080, 1920))
    with pytest.raises(InputError, match="field of view"):
        pool_camera(setup_for(truth), size_px=(1920, 1440))


def test_corners_begun_elsewhere_are_named_with_the_order_that_fits():
    truth = overhead_camera()
    rolled = np.roll(truth.corners_px, 1, axis=0).tolist()
    with pytest.raises(InputError, match="begin with the corner now listed second"):
        pool_camera(setup_for(truth, pool_corners_px=rolled))
    with pytest.raises(InputError, match="swap the second and the fourth"):
        camera_from_corners(LENS, truth.corners_px[[0, 3, 2, 1]], CORNERS_M, 1.333)


def test_corners_of_no_pool_are_refused_and_doubtful_ones_remarked():
    truth = overhead_camera()
    moved = truth.corners_px.copy()
    moved[2] += [150, -120]
    with pytest.raises(InputError, match=r"No order fits either.*raw frame"):
        pool_camera(setup_for(truth, pool_corners_px=moved.tolist()))
    moved = truth.corners_px.copy()
    moved[2] += [12, -8]
    assert (
        "look at them with `bluekoi pool`"
        in pool_camera(setup_for(truth, pool_corners_px=moved.tolist())).remarks[0]
    )


def test_stated_covariance_is_that_of_mapped_noise():
    camera, rng = overhead_camera(), np.random.default_rng(5)
    cov_px = np.array([[0.5, 0.2], [0.2, 0.3]])
    place = pool_to_pixels(camera, np.array([[0.2, 1.4, -0.04]]))
    noisy = place + rng.multivariate_normal([0, 0], cov_px, 4000)
    n = len(noisy)
    keypoints = Keypoints(
        time_s=np.arange(n) / 30,
        names=("hinge",),
        xy_px=noisy[:, None],
        likelihood=np.ones((n, 1)),
        cov_px2=np.broadcast_to(cov_px, (n, 1, 2, 2)),
    )
    mapped = map_keypoints(camera, keypoints, 0.04)
    found = np.cov(mapped.xy_m[:, 0].T)
    slope = pixel_to_pool_jacobian(camera, place, 0.04)[0]
    assert np.allclose(mapped.cov_m2[0, 0], slope @ cov_px @ slope.T, rtol=0.01)
    assert np.allclose(found, slope @ cov_px @ slope.T, rtol=0.08, atol=1e-9)


def test_homography_alone_maps_its_plane_and_states_a_bound_that_holds():
    truth = overhead_camera(tilt=0.03)
    found = pool_camera(setup_for(truth, matrix=None, distortion=None))
    assert np.allclose(map_to_pool(found, truth.corners_px, 0.0), CORNERS_M[:, :2], atol=1e-9)
    assert np.allclose(pool_to_pixels(found, CORNERS_M), truth.corners_px, atol=1e-6)
    xyz = np.column_stack([pool_points(), np.full(60, -0.04)])
    error = np.linalg.norm(
        map_to_pool(found, pool_to_pixels(truth, xyz), 0.04) - xyz[:, :2], axis=1
    )
    assert 0.002 < error.max() < found.bound_m < 0.3
    assert "calibrate the camera" in found.remarks[0]


def test_homography_alone_still_catches_a_wrong_first_corner():
    rolled = np.roll(overhead_camera().corners_px, 1, axis=0).tolist()
    with pytest.raises(InputError, match="begin with the corner now listed second"):
        pool_camera(
            setup_for(overhead_camera(), pool_corners_px=rolled, matrix=None, distortion=None)
        )


def test_keypoints_outside_the_pool_are_remarked():
    camera = overhead_camera()
    n = 10
    keypoints = Keypoints(
        time_s=np.arange(n) / 30,
        names=("hinge",),
        xy_px=np.full((n, 1, 2), 3.0),
        likelihood=np.ones((n, 1)),
        cov_px2=np.full((n, 1, 2, 2), np.nan),
    )
    assert "100 % of the confident keypoints" in map_keypoints(camera, keypoints, 0.04).remarks[0]


@pytest.mark.parametrize("size", [(1920, 1080), (1280, 720), (1066, 600), (2880, 1620)])
def test_a_film_scaled_alike_is_followed_by_the_whole_camera_section(size):
    given = setup_for(overhead_camera())
    reported = setup_in_recording_pixels(given, size)
    assert reported.camera.image_size_px == size
    by_size, by_section = pool_camera(given, size), pool_camera(reported)
    points = np.column_stack([pool_points(), np.full(60, -0.04)])
    np.testing.assert_allclose(
        pool_to_pixels(by_section, points), pool_to_pixels(by_size, points), atol=1e-6
    )
    back = to_study_pixels(given, size, np.array(reported.camera.pool_corners_px))
    np.testing.assert_allclose(back, np.array(given.camera.pool_corners_px), atol=1e-9)
    StudySettings.model_validate(reported.model_dump())


def test_a_film_of_another_shape_is_refused():
    with pytest.raises(InputError, match="1440 x 1080"):
        setup_in_recording_pixels(setup_for(overhead_camera()), (1440, 1080))
