"""Detection on rendered footage: right points, honest likelihoods and covariances."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np
import pytest

from bluekoi.data import BODY_PART_NAMES, Frame
from bluekoi.errors import InputError
from bluekoi.keypoints import markers, silhouette
from bluekoi.keypoints.outline.ghost_removal import body_outline_px
from bluekoi.keypoints.outline.movement_check import frames_change_where_body_moved
from bluekoi.keypoints.outline.plane import swimming_plane_map
from bluekoi.study import StudySettings, Trial
from bluekoi.synthetic.footage import render_frames
from bluekoi.synthetic.optics import pool_corners
from bluekoi.synthetic.picture_conditions import PICTURE_CONDITIONS_BY_NAME
from bluekoi.synthetic.synthetic_study_design import picture_conditions_design
from bluekoi.synthetic.trial import camera_of_design_at_time, frame_truth, solve_trial

RIGID_KEYPOINTS = (0, 1, 2)
STRAIGHT, LEFT, RIGHT = "T01", "T02", "T03"


def setup_of_design(design, **detection) -> StudySettings:
    camera, tank = camera_of_design_at_time(design, -1.0), design.tank
    (fx, fy), (cx, cy) = camera.focal_px, camera.middle_px
    robot = {name: getattr(tank.robot, name) for name in tank.robot.__dataclass_fields__}
    return StudySettings(
        robot=robot,
        camera={
            "model": camera.lens,
            "image_size_px": camera.size_px,
            "matrix": ((fx, 0, cx), (0, fy, cy), (0, 0, 1)),
            "distortion": camera.distortion,
            "pool_corners_px": [tuple(map(float, c)) for c in pool_corners(camera, tank.pool_m)],
        },
        detection=detection,
    )


def trial_of_plan(plan) -> Trial:
    return Trial(
        trial_id=plan.trial_id,
        source="v.mp4",
        power_pct=plan.power_pct,
        head_angle_deg=plan.head_angle_deg,
        head_length_m=plan.head_length_m,
    )


@lru_cache(maxsize=3)
def rendered_trial(
    step: str, name: str, *, seconds: float = 2.4, every: int = 4, colour: bool = False
):
    """Frames, setup, trial and true keypoints (frames, 5, 2) of one rendered trial."""
    design = picture_conditions_design(PICTURE_CONDITIONS_BY_NAME[step], longest_s=seconds)
    trial = solve_trial(design, name)
    number = range(0, len(trial.time_s), every)
    thinned = replace(trial, time_s=trial.time_s[::every])
    film = []
    for i, planes in zip(number, render_frames(design, thinned), strict=True):
        bgr = _planes_to_bgr(planes) if colour else None
        film.append(Frame(i, float(trial.time_s[i]), planes.luma, bgr))
    truth = frame_truth(design, thinned)["keypoints_px"]
    return film, setup_of_design(design), trial_of_plan(trial.plan), truth


def _planes_to_bgr(planes) -> np.ndarray:
    full = [cv2.resize(c, planes.luma.shape[::-1]) for c in planes.chroma]
    return cv2.cvtColor(np.stack([planes.luma, full[1], full[0]], axis=2), cv2.COLOR_YCrCb2BGR)


def keypoint_errors(found, truth) -> np.ndarray:
    return np.linalg.norm(found.xy_px - truth, axis=2)


def pulls(found, truth) -> np.ndarray:
    """Root mean square of the normalised error of each part; 1 where the covariance is right."""
    off = found.xy_px - truth
    square = np.einsum("nki,nkij,nkj->nk", off, np.linalg.inv(found.cov_px2), off) / 2
    return np.sqrt(square.mean(axis=0))


@pytest.mark.parametrize("name", [STRAIGHT, LEFT, RIGHT])
def test_middle_step_is_found_to_a_third_of_a_pixel(name):
    film, setup, trial, truth = rendered_trial("middle", name)
    found = silhouette.detect_keypoints(lambda: film, setup, trial)
    off = keypoint_errors(found, truth)
    assert found.names == BODY_PART_NAMES
    assert np.all(np.median(off, axis=0)[list(RIGID_KEYPOINTS)] <= 0.3)
    assert off.max() < 3.0
    assert np.mean(found.likelihood > 0.9) > 0.97
    assert np.all(np.median(off, axis=0) < 0.5)


@pytest.mark.parametrize("stated", [1.0, pytest.param(0.98, marks=pytest.mark.long), 1.03])
@pytest.mark.parametrize("name", [STRAIGHT, LEFT])
def test_the_whole_length_is_seen_to_a_quarter_of_a_percent(name, stated):
    """Where the pool is stated too short, all is seen too short by the same share."""
    film, setup, trial, _ = rendered_trial("middle", name)
    pool = {k: getattr(setup.pool, k) * stated for k in ("length_m", "width_m")}
    wrong = setup.model_copy(update={"pool": setup.pool.model_copy(update=pool)})
    found = silhouette.detect_keypoints(lambda: film, wrong, trial)
    assert found.length_seen is not None
    assert np.nanmedian(found.length_seen) == pytest.approx(stated, abs=0.0025)


LENGTHS = ("length_m", "width_m", "depth_m")
ROBOT_LENGTHS = ("body_length_m", "head_length_m", "head_span_m", "hinge_to_com_m",
                 "tail_length_m", "keypoint_depth_m")  # fmt: skip


def with_stated_body_length(
    setup: StudySettings, trial: Trial, body_length_m: float
) -> tuple[StudySettings, Trial]:
    """The same setup and trial with all lengths scaled to a body length."""
    scale = body_length_m / setup.robot.body_length_m
    pool = {name: scale * getattr(setup.pool, name) for name in LENGTHS}
    robot = {name: scale * getattr(setup.robot, name) for name in ROBOT_LENGTHS}
    changed = {
        "pool": setup.pool.model_copy(update=pool),
        "robot": setup.robot.model_copy(update=robot),
    }
    head = {"head_length_m": scale * trial.head_length_m}
    return setup.model_copy(update=changed), trial.model_copy(update=head)


@pytest.mark.parametrize("body_length_m", [0.005, 0.05, 5.0])
def test_detection_does_not_depend_on_the_metric_scale_that_a_study_declares(body_length_m):
    """Issue 31, point 1: same pixels, same result, from 5 mm to 5 m."""
    film, setup, trial, _ = rendered_trial("middle", LEFT, seconds=1.2)
    usual = silhouette.detect_keypoints(lambda: film, setup, trial)
    found = silhouette.detect_keypoints(
        lambda: film, *with_stated_body_length(setup, trial, body_length_m)
    )
    for name in ("xy_px", "likelihood", "cov_px2"):
        np.testing.assert_allclose(getattr(found, name), getattr(usual, name), rtol=1e-9)


def over_itself_turned_by_half_a_turn(film):
    """Two dark bodies of one shape."""
    return [replace(f, luma=np.minimum(f.luma, f.luma[::-1, ::-1])) for f in film]


@pytest.mark.parametrize("part", [0, 2])
@pytest.mark.parametrize("turned", [False, True])
def test_of_two_robots_that_at_the_stated_start_is_followed(part, turned):
    film, setup, trial, truth = rendered_trial("middle", LEFT, seconds=1.2)
    both = over_itself_turned_by_half_a_turn(film)
    meant = np.array(film[0].luma.shape[::-1]) - 1 - truth if turned else truth
    u, v = meant[0, part]
    found = silhouette.detect_keypoints(
        lambda: both, setup, trial.model_copy(update={"start_x_px": u, "start_y_px": v})
    )
    assert np.nanmax(keypoint_errors(found, meant)[:, :3]) < 5.0


def test_a_start_where_no_robot_lies_finds_none_and_says_so():
    film, setup, trial, _ = rendered_trial("middle", LEFT, seconds=1.2)
    found = silhouette.detect_keypoints(
        lambda: film, setup, trial.model_copy(update={"start_x_px": 3.0, "start_y_px": 3.0})
    )
    assert not np.isfinite(found.xy_px).any()
    assert any("No robot was found: none at start_x_px 3" in text for text in found.remarks)


def test_a_second_robot_in_the_picture_is_reported():
    film, setup, trial, truth = rendered_trial("middle", LEFT)
    both = over_itself_turned_by_half_a_turn(film)
    found = silhouette.detect_keypoints(lambda: both, setup, trial)
    assert sum("second body of the robot's shape" in remark for remark in found.remarks) == 1
    turned = np.array(film[0].luma.shape[::-1]) - 1 - truth
    off = np.minimum(keypoint_errors(found, truth), keypoint_errors(found, turned))
    assert np.nanmedian(off) < 1.0  # it is one of the two that is followed


@pytest.mark.parametrize("step", ["middle", "second_body", "hand"])
def test_one_robot_is_not_taken_for_two(step):
    film, setup, trial, _ = rendered_trial(step, LEFT)
    found = silhouette.detect_keypoints(lambda: film, setup, trial)
    assert not any("second body" in remark for remark in found.remarks)


def test_stated_covariances_have_the_right_width():
    square = []
    for name in (STRAIGHT, LEFT, RIGHT):
        film, setup, trial, truth = rendered_trial("middle", name)
        square.append(
            pulls(silhouette.detect_keypoints(lambda f=film: f, setup, trial), truth) ** 2
        )
    width = np.sqrt(np.mean(square, axis=0))
    assert np.all((width > 0.75) & (width < 1.25))
    assert np.sqrt(np.mean(width[list(RIGID_KEYPOINTS)] ** 2)) == pytest.approx(1.0, abs=0.2)


def test_a_straight_robot_is_learned_in_moving_light():
    """Parts of it alone stand out; head and tail are distinguished, nothing wrong is believed."""
    film, setup, trial, truth = rendered_trial("hard", STRAIGHT, every=3)
    found = silhouette.detect_keypoints(lambda: film, setup, trial)
    off = keypoint_errors(found, truth)
    seen = np.isfinite(off[:, 1])
    assert seen.mean() > 0.4
    assert np.all(np.median(off[seen], axis=0)[list(RIGID_KEYPOINTS)] < 2.0)
    axis, right = (points[seen, 0] - points[seen, 3] for points in (found.xy_px, truth))
    assert np.all(np.sum(axis * right, axis=1) > 0)
    assert not np.any((off > 5.0) & (found.likelihood > 0.9))


def test_a_tail_smeared_by_the_exposure_says_so():
    film, setup, trial, truth = rendered_trial("blur", STRAIGHT)
    found = silhouette.detect_keypoints(lambda: film, setup, trial)
    sharp, setup, trial, sharp_truth = rendered_trial("middle", STRAIGHT)
    clear = silhouette.detect_keypoints(lambda: sharp, setup, trial)
    believed = found.likelihood[:, 4] > 0.9
    assert 0.6 < pulls(found, truth)[4] < 1.6
    assert 0.6 < pulls(clear, sharp_truth)[4] < 1.4
    wide, narrow = (np.median(k.cov_px2[:, 4].trace(axis1=1, axis2=2)) for k in (found, clear))
    assert wide > 4 * narrow
    assert believed.mean() > 0.5


@pytest.mark.parametrize(
    ("step", "name"),
    [("hand", STRAIGHT), ("second_body", LEFT), ("occluder", LEFT), ("leaving", STRAIGHT)],
)
def test_things_in_the_way_never_make_a_confident_wrong_point(step, name):
    film, setup, trial, truth = rendered_trial(step, name)
    found = silhouette.detect_keypoints(lambda: film, setup, trial)
    wrong = (keypoint_errors(found, truth) > 5.0) & (found.likelihood > 0.9)
    assert wrong.sum() == 0
    assert np.mean(found.likelihood[:, 2] > 0.5) > 0.6


def test_a_robot_that_never_moves_is_found_and_reported():
    film, setup, trial, truth = rendered_trial("middle", LEFT)
    still = [replace(frame, luma=film[0].luma) for frame in film[:6]]
    found = silhouette.detect_keypoints(lambda: still, setup, trial)
    assert any("hardly left its place" in remark for remark in found.remarks)
    assert np.all(keypoint_errors(found, truth[:1])[:, :3] < 5.0)


def test_an_empty_pool_has_no_robot():
    film, setup, trial, _ = rendered_trial("middle", LEFT)
    empty = np.quantile([frame.luma for frame in film], 0.9, axis=0)
    rng = np.random.default_rng(0)
    noisy = [
        replace(f, luma=np.clip(empty + rng.normal(0, 2, empty.shape), 0, 255).astype(np.uint8))
        for f in film[:5]
    ]
    found = silhouette.detect_keypoints(lambda: noisy, setup, trial)
    assert np.all(found.likelihood < 0.5)
    assert any("without the robot" in r or "No robot" in r for r in found.remarks)


def test_a_template_that_slides_while_the_pictures_stay_as_they_are_is_on_no_body():
    """As along the straight dark rim of an empty pool, in a background bridged across it."""
    film, setup, trial, _ = rendered_trial("middle", LEFT)
    scene, outline, _ = silhouette.learn_scene_and_template(
        lambda: film, film, swimming_plane_map(setup), setup, trial
    )
    assert outline is not None
    assert frames_change_where_body_moved(outline, scene)
    first = outline.samples[0][0]
    slides = replace(outline, samples=tuple((first, fit) for _, fit in outline.samples))
    rests = replace(outline, samples=tuple((first, outline.samples[0][1]) for _ in range(3)))
    assert not frames_change_where_body_moved(slides, scene)
    assert frames_change_where_body_moved(rests, scene)


@pytest.mark.parametrize("ahead_bl", [0.05, 0.1])
def test_a_body_that_moves_a_little_ahead_uncovers_the_floor(ahead_bl):
    """Behind it, its tail covers the floor; ahead, the body does."""
    film, setup, trial, _ = rendered_trial("middle", STRAIGHT, seconds=1.2)
    scene, outline, _ = silhouette.learn_scene_and_template(
        lambda: film, film, swimming_plane_map(setup), setup, trial
    )
    assert outline is not None
    frame, fit = outline.samples[0]
    ahead = np.array([np.cos(fit.pose[2]), np.sin(fit.pose[2]), 0.0, 0.0]) * ahead_bl
    moved = replace(fit, pose=fit.pose + ahead)
    contrast = scene.floor.astype(float) - outline.template.core_grey_level
    pictures = []
    for one in (fit, moved):
        body = np.zeros(scene.floor.shape)
        cv2.fillPoly(body, [body_outline_px(one, scene, outline.template)], 0.4)
        shown = scene.floor - cv2.GaussianBlur(body, (0, 0), 1.0) * contrast
        pictures.append((replace(frame, luma=shown.round().astype(np.uint8)), one))
    assert frames_change_where_body_moved(replace(outline, samples=tuple(pictures)), scene)


def test_a_nudged_camera_is_reported_and_a_still_one_is_not():
    film, setup, trial, _ = rendered_trial("nudged", STRAIGHT)
    found = silhouette.detect_keypoints(lambda: film, setup, trial)
    assert any("the camera moved by about" in remark for remark in found.remarks)
    still, setup, trial, _ = rendered_trial("middle", STRAIGHT)
    plain = silhouette.detect_keypoints(lambda: still, setup, trial)
    assert not any("camera" in remark for remark in plain.remarks)


def test_no_frames_is_a_fault():
    _, setup, trial, _ = rendered_trial("middle", LEFT)
    with pytest.raises(InputError, match="no frames"):
        silhouette.detect_keypoints(list, setup, trial)


def test_a_brighter_robot_is_found_as_well():
    film, setup, trial, truth = rendered_trial("calm", LEFT)
    bright = [replace(frame, luma=255 - frame.luma) for frame in film]
    found = silhouette.detect_keypoints(lambda: bright, setup, trial)
    assert np.all(np.median(keypoint_errors(found, truth), axis=0)[list(RIGID_KEYPOINTS)] <= 1.0)


def test_markers_are_found_by_hue():
    film, setup, trial, truth = rendered_trial("markers", LEFT, seconds=1.0, colour=True)
    hues = {"head_tip": 2, "hinge": 50, "core_center": 128, "tail_base": 306, "tail_tip": 29}
    detection = setup.detection.model_copy(update={"marker_hues_deg": hues})
    setup = setup.model_copy(update={"detection": detection})
    found = markers.detect_keypoints(lambda: film, setup, trial)
    off = keypoint_errors(found, truth)
    assert np.all(np.nanmedian(off, axis=0) < 0.6)
    assert not np.any((off > 5) & (found.likelihood > 0.9))
    with pytest.raises(InputError, match="colour frames"):
        markers.detect_keypoints(lambda: [replace(film[0], bgr=None)], setup, trial)


def test_markers_need_hues():
    film, setup, trial, _ = rendered_trial("middle", LEFT)
    with pytest.raises(InputError, match="marker_hues_deg"):
        markers.detect_keypoints(lambda: film, setup, trial)
