"""Geometry errors made one at a time and named from rigid distances; the calibration's own std."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bluekoi.camera import Lens, PoolCamera, camera_from_corners, map_to_pool, pool_to_pixels
from bluekoi.camera.calibration_uncertainty import (
    calibration_covariance_at_pixels,
    calibration_covariance_factor,
)
from bluekoi.camera.geometry_hypotheses import fit_hypothesis
from bluekoi.camera.resection import gauss_newton_pose_update, pool_rectangle, pose_from_marks
from bluekoi.camera.rigid_distances import CameraGeometry, rigid_distances
from bluekoi.camera.rigid_length_check import (
    check_rigid_distances,
    estimate_keypoint_depth,
)
from bluekoi.camera.whole_body_length import systematic_length_error_share, whole_body_lengths
from bluekoi.data import KeypointPositions
from bluekoi.errors import InputError
from bluekoi.study import Robot
from paper_robot import PAPER_ROBOT

PARTS = ("head_tip", "hinge", "core_center", "tail_base")
DEPTH_M = 0.04
LENS = Lens(
    "pinhole",
    np.array([[1130.0, 0, 955], [0, 1130, 542], [0, 0, 1]]),
    np.array([-0.12, 0.03, 0.0004, -0.0003, 0]),
    (1920, 1080),
)


def camera_above(lens: Lens = LENS, size: tuple[float, float] = (2.6, 1.6)) -> PoolCamera:
    turn = Rotation.from_rotvec([0.04, -0.03, 0.01]).as_matrix() @ np.diag([1.0, -1.0, -1.0])
    shift = -turn @ np.array([1.25, 0.85, 2.3])
    corners = pool_rectangle(*size, 0.0)
    blank = PoolCamera(
        size_px=lens.size_px,
        corners_px=np.zeros((4, 2)),
        corners_m=corners,
        refractive_index=1.333,
        residuals_px=np.zeros((4, 2)),
        corner_std_px=1.0,
        lens=lens,
        rotation=turn,
        translation=shift,
    )
    return camera_from_corners(lens, pool_to_pixels(blank, corners), corners, 1.333)


TRUTH = camera_above()


def random_rigid_points(n: int, rng: np.random.Generator, *, tip_m: float = 0.12) -> np.ndarray:
    """Rigid points (n, 4, 2) all over the pool."""
    center = rng.uniform([0.25, 0.25], [2.35, 1.35], (n, 2))
    psi = rng.uniform(-np.pi, np.pi, n)
    theta = psi - rng.choice([-0.7, 0.0, 0.7], n)
    core = np.column_stack([np.cos(psi), np.sin(psi)])
    head = np.column_stack([np.cos(theta), np.sin(theta)])
    hinge = center + 0.04 * core
    return np.stack([hinge + tip_m * head, hinge, center, center - 0.171 * core], axis=1)


def mapped_trials(
    believed: PoolCamera, *, seed=1, noise_px=0.4, tip_m=0.12, depth_m=DEPTH_M, truth=TRUTH
) -> list[KeypointPositions]:
    """Twelve trials seen by the true camera and mapped by the believed one; depth_m: of all points,
    or of each (480,).
    """
    rng = np.random.default_rng(seed)
    trials = []
    for _ in range(12):
        points = random_rigid_points(120, rng, tip_m=tip_m).reshape(-1, 2)
        image = pool_to_pixels(
            truth, np.column_stack([points, np.broadcast_to(-depth_m, len(points))])
        )
        image = image + rng.normal(0, noise_px, image.shape)
        xy = map_to_pool(believed, image, DEPTH_M).reshape(120, 4, 2)
        ones = np.ones((120, 4))
        cov = np.full((120, 4, 2, 2), np.nan)
        trials.append(KeypointPositions(np.arange(120) / 30, PARTS, xy, cov, ones))
    return trials


def geometry_check(believed: PoolCamera, **made):
    distances = rigid_distances(mapped_trials(believed, **made), [0.12] * 12, Robot(**PAPER_ROBOT))
    return check_rigid_distances(CameraGeometry(believed, DEPTH_M), distances)


@pytest.mark.parametrize("seed", range(4))
def test_nothing_is_said_of_clean_data(seed):
    found = geometry_check(TRUTH, seed=seed)
    assert found.outcome == "nothing"
    assert abs(found.mean_excess) < 5 * found.mean_excess_std + 1e-5
    assert found.rivals == ()
    assert "no geometry error shows" in found.sentence


def test_what_a_detector_does_everywhere_alike_is_no_geometry_error():
    """A nose marked 0.05 mm short in every frame of every trial: sure, and nothing."""
    found = geometry_check(TRUTH, tip_m=0.11995, noise_px=0.05)
    nose = next(e for e in found.fits if e.hypothesis.parameters == ("head_tip_m",))
    assert nose.p_value < 1e-6
    assert nose.share < 0.0005
    assert found.outcome == "nothing"


def test_a_pool_measured_short_is_a_scale_error():
    corners = pool_rectangle(2.6 * 0.985, 1.6 * 0.985, 0.0)
    believed = camera_from_corners(LENS, TRUTH.corners_px, corners, 1.333)
    found = geometry_check(believed)
    assert found.outcome == "scale_error" or "scale_error" in found.rivals
    scale = next(e for e in found.fits if e.hypothesis.name == "scale_error")
    assert scale.values[0] == pytest.approx(0.015, abs=0.002)
    assert found.mean_excess == pytest.approx(-0.015, abs=0.002)


def whole_length_check(believed: PoolCamera, given: tuple[str, ...] = (), **made):
    """The check of the whole lengths alone, the tail behind the others as far as it is seen."""
    trials, seen = [], []
    for one in mapped_trials(believed, **made):
        tip, hinge, center, base = one.xy_m.transpose(1, 0, 2)
        end = base + (base - center) * 0.066 / 0.171
        parts = [tip - hinge, hinge - center, center - end]
        ratio = np.sum(np.linalg.norm(parts, axis=2), axis=0) / (0.12 + 0.211 + 0.066)
        seen.append(np.column_stack([np.arange(120), ratio])[::2])
        xy = np.concatenate([one.xy_m, end[:, None]], axis=1)
        ones, cov = np.ones((120, 5)), np.full((120, 5, 2, 2), np.nan)
        trials.append(KeypointPositions(one.time_s, (*PARTS, "tail_tip"), xy, cov, ones))
    lengths = whole_body_lengths(trials, seen, [0.12] * 12, Robot(**PAPER_ROBOT))
    geometry = CameraGeometry(believed, DEPTH_M)
    return check_rigid_distances(
        geometry, lengths, min_share=systematic_length_error_share(geometry, lengths), given=given
    )


@pytest.mark.parametrize(("share", "outcome"), [(1.0, False), (0.997, False), (0.98, True)])
def test_the_whole_length_alone_shows_a_scale_error(share, outcome):
    corners = pool_rectangle(2.6 * share, 1.6 * share, 0.0)
    found = whole_length_check(camera_from_corners(LENS, TRUTH.corners_px, corners, 1.333))
    assert found.mean_excess == pytest.approx(share - 1, abs=0.001)
    assert ("scale_error" in {found.outcome, *found.rivals}) == outcome
    assert outcome or found.outcome == "nothing"


def test_a_depth_that_was_given_gives_way_to_the_scale(monkeypatch):
    """The patterns are nearly the same: which is ahead by a hair is left to the light."""

    def by_a_hair(hypothesis, *args):
        found = fit_hypothesis(hypothesis, *args)
        ahead = 4.0 if hypothesis.name == "keypoint_depth" else 0.0
        return replace(found, gain=found.gain + ahead)

    monkeypatch.setattr("bluekoi.camera.rigid_length_check.fit_hypothesis", by_a_hair)
    free = whole_length_check(TRUTH, depth_m=DEPTH_M + 0.03)
    given = whole_length_check(TRUTH, ("keypoint_depth",), depth_m=DEPTH_M + 0.03)
    assert (free.outcome, given.outcome) == ("keypoint_depth", "scale_error")
    assert "scale_error" in free.rivals
    assert "keypoint_depth" in given.rivals
    assert "the pool is larger than stated" in given.sentence
    assert not any(e.hypothesis.name == "keypoint_bias" for e in free.fits)


def test_a_wrong_distortion_is_a_lens_error():
    wrong = Lens("pinhole", LENS.matrix, LENS.distortion * [0.6, 1, 1, 1, 1], LENS.size_px)
    believed = camera_from_corners(wrong, TRUTH.corners_px, TRUTH.corners_m, 1.333)
    found = geometry_check(believed)
    assert found.outcome == "lens_error"
    assert found.best.values[1] == pytest.approx(-0.048, abs=0.02)


def test_a_lens_far_off_is_followed_to_its_error_and_is_none_of_scale():
    """k1 off by 0.2: by patterns of first order its focal length would be off implausibly."""
    wrong = Lens("pinhole", LENS.matrix, np.add(LENS.distortion, [0.2, 0, 0, 0, 0]), LENS.size_px)
    believed = camera_from_corners(wrong, TRUTH.corners_px, TRUTH.corners_m, 1.333)
    found = geometry_check(believed)
    assert found.outcome == "lens_error"
    assert found.rivals == ()
    focal, k1 = found.best.values
    assert abs(focal) < 0.08
    assert k1 == pytest.approx(-0.2, abs=0.02)


def test_a_camera_turned_after_the_corners_were_taken_is_a_camera_shift():
    turn = Rotation.from_rotvec([0.012, -0.008, 0]).as_matrix()
    moved = replace(TRUTH, rotation=turn @ TRUTH.rotation, translation=turn @ TRUTH.translation)
    found = geometry_check(TRUTH, truth=moved)
    assert found.outcome == "camera_shift"
    assert found.best.values[0] == pytest.approx(0.012, abs=0.003)
    assert found.best.values[1] == pytest.approx(-0.008, abs=0.003)


def test_refraction_left_out_is_named_or_named_among_rivals():
    dry = replace(TRUTH, refractive_index=1.0)
    found = geometry_check(dry)
    names = {found.outcome, *found.rivals}
    assert "uncorrected_refraction" in names
    assert names <= {"uncorrected_refraction", "keypoint_depth", "scale_error"}


def test_a_robot_that_sinks_during_each_trial_is_no_error_of_scale():
    deeper = np.repeat(DEPTH_M + 0.009 * np.arange(120) / 30, 4)
    found = geometry_check(TRUTH, depth_m=deeper)
    assert found.outcome == "sinking"
    assert found.rivals == ()
    assert found.best.values[0] == pytest.approx(0.009, abs=3 * found.best.stds[0] + 2e-4)
    assert found.best.stds[0] < 0.002


def test_a_head_tip_marked_short_is_a_keypoint_bias_of_that_part():
    found = geometry_check(TRUTH, tip_m=0.117)
    assert found.outcome == "keypoint_bias"
    assert found.best.hypothesis.parameters == ("head_tip_m",)
    assert found.best.values[0] == pytest.approx(-0.003, abs=0.0004)


def test_the_map_shows_the_error_and_what_the_named_cause_predicts():
    wrong = Lens("pinhole", LENS.matrix, LENS.distortion * [0.6, 1, 1, 1, 1], LENS.size_px)
    believed = camera_from_corners(wrong, TRUTH.corners_px, TRUTH.corners_m, 1.333)
    grid = geometry_check(believed).map
    seen = grid.count > 50
    assert grid.excess.shape == (5, 8)
    assert np.corrcoef(grid.excess[seen], grid.model[seen])[0, 1] > 0.9


def test_depth_comes_from_the_same_distances_with_an_honest_std():
    pulls = []
    for seed in range(4):
        trials = mapped_trials(TRUTH, seed=seed, depth_m=0.07)
        depth, std = estimate_keypoint_depth(
            TRUTH, trials, depth_m=DEPTH_M, head_lengths_m=[0.12] * 12, robot=Robot(**PAPER_ROBOT)
        )
        pulls.append((depth - 0.07) / std)
        assert std < 0.004
    assert np.sqrt(np.mean(np.square(pulls))) < 1.8


def test_trials_without_rigid_pairs_are_a_fault():
    trials = mapped_trials(TRUTH)[:1]
    blind = replace(trials[0], likelihood=np.zeros((120, 4)))
    with pytest.raises(InputError, match="no two neighbouring rigid keypoints"):
        rigid_distances([blind], [0.12], Robot(**PAPER_ROBOT))


def test_calibration_modes_are_what_misclicked_corners_do():
    rng = np.random.default_rng(2)
    spot = pool_to_pixels(TRUTH, np.array([[0.3, 0.3, -0.04], [2.2, 1.3, -0.04]]))
    camera = replace(TRUTH, corner_std_px=1.0)
    modes = calibration_covariance_factor(camera, spot, DEPTH_M)
    assert modes.shape == (2, 2, 8)
    places = []
    for _ in range(120):
        clicked = TRUTH.corners_px + rng.normal(0, 1.0, (4, 2))
        again = camera_from_corners(LENS, clicked, TRUTH.corners_m, 1.333)
        places.append(map_to_pool(again, spot, DEPTH_M))
    found = np.std(places, axis=0)
    stated = np.sqrt(
        np.diagonal(calibration_covariance_at_pixels(camera, spot, DEPTH_M), axis1=1, axis2=2)
    )
    assert np.allclose(found, stated, rtol=0.25)


def test_pose_of_nearby_corners_is_the_whole_fits_to_two_hundredths_of_the_change():
    moved = TRUTH.corners_px + np.random.default_rng(4).normal(0, 1.0, (4, 2))
    marks = (TRUTH.corners_m, TRUTH.refractive_index)
    whole = pose_from_marks(LENS, moved, *marks)
    near = gauss_newton_pose_update(
        LENS, moved, *marks, rotation=TRUTH.rotation, translation=TRUTH.translation
    )  # fmt: skip
    for own, right, before in zip(near[:2], whole[:2], (TRUTH.rotation, TRUTH.translation),
                                  strict=True):  # fmt: skip
        assert np.abs(own - right).max() < 0.02 * np.abs(right - before).max()
    assert near[2] == pytest.approx(whole[2], abs=1e-2)
