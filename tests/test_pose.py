"""Rigid pose on exact bodies, with noise of the stated width, missing parts and outliers."""

import numpy as np
import pytest

from bluekoi.data import BODY_PART_NAMES, KeypointPositions
from bluekoi.errors import InputError
from bluekoi.pose import rigid_pose, unwrapped_angles
from bluekoi.study import Robot
from paper_robot import PAPER_ROBOT

ROBOT = Robot(**PAPER_ROBOT)
HEAD_M = 0.12


def circle_poses(n: int = 300, turns: float = 1.5, phi: float = 0.5) -> np.ndarray:
    """A circle: x, y, heading, head angle (frames, 4)."""
    psi = 2 + np.linspace(0, 2 * np.pi * turns, n)
    x, y = 1.3 + 0.5 * np.sin(psi), 0.8 - 0.5 * np.cos(psi)
    return np.column_stack([x, y, psi, np.full(n, phi)])


def keypoint_positions(
    pose: np.ndarray, std_m: float = 0.0, *, scale: float = 1.0, stated=True, seed=1
):
    core = np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])])
    theta = pose[:, 2] - pose[:, 3]
    head = np.column_stack([np.cos(theta), np.sin(theta)])
    center, hinge = pose[:, :2], pose[:, :2] + 0.04 * core
    tail = center - 0.171 * core
    points = [hinge + HEAD_M * head, hinge, center, tail, tail - 0.066 * core]
    xy = np.stack(points, axis=1) * scale
    xy = xy + np.random.default_rng(seed).normal(0, 1, xy.shape) * std_m
    cov = np.broadcast_to(np.eye(2) * max(std_m, 1e-6) ** 2, (*xy.shape, 2)).copy()
    if not stated:
        cov[:] = np.nan
    shape = xy.shape[:2]
    return KeypointPositions(np.arange(len(pose)) / 30, BODY_PART_NAMES, xy, cov, np.ones(shape))


def changed_frames(given: KeypointPositions, **fields) -> KeypointPositions:
    return KeypointPositions(**{**given.__dict__, **fields})


def test_exact_circle_comes_back_unwrapped():
    expected = circle_poses()
    pose = rigid_pose(keypoint_positions(expected), ROBOT, HEAD_M)
    offset = pose.values[0, 2] - expected[0, 2]
    assert np.isclose(offset % (2 * np.pi), 0, atol=1e-9) or np.isclose(
        offset % (2 * np.pi), 2 * np.pi, atol=1e-9
    )
    assert np.allclose(pose.values - [0, 0, offset, 0], expected, atol=1e-9)
    assert pose.remarks == ()


@pytest.mark.parametrize("turns", [-1.5, 0.0, 1.5])
def test_frames_turned_end_for_end_do_not_wind_the_heading(turns):
    """One, two and four together, exactly and by a little less or more than half a turn: all the
    other frames keep their heading (one of -3.14 and back by -3.13 had added a whole turn).
    """
    expected = circle_poses(turns=turns)
    flipped = [40, 100, 101, 170, 171, 172, 173, 250]
    off = np.array([3.10, 3.18, 3.10, np.pi, np.pi, np.pi, np.pi, -3.10])
    shown = expected.copy()
    shown[flipped, 2] += off
    pose = rigid_pose(keypoint_positions(shown, 1e-4), ROBOT, HEAD_M)
    others = np.setdiff1d(np.arange(len(expected)), flipped)
    error = pose.values[others, 2] - expected[others, 2]
    assert np.ptp(error) < 0.05
    assert np.all(np.abs(pose.values[flipped, 2] - expected[flipped, 2] - error[0]) < np.pi + 0.05)


def test_a_long_stretch_of_poor_frames_loses_no_turn():
    """2.5 s at 1.5 rad/s, stated eleven times worse than usual, within the trial and at its end."""
    t = np.arange(300) / 30
    true = 1.5 * t
    for poor in ((t > 4) & (t < 6.5), t > 7, t < 2):
        variance = np.where(poor, 1.21e-4, 1e-6)
        found = unwrapped_angles(np.angle(np.exp(1j * true)), variance)
        assert np.ptp(found - true) < 1e-9


@pytest.mark.parametrize("hz", [3.0, 10.0, 60.0])
def test_a_fast_turn_in_few_frames_keeps_its_turns(hz):
    true = 2.5 * np.arange(0.0, 20.0, 1 / hz)
    found = unwrapped_angles(np.angle(np.exp(1j * true)), np.full(len(true), 1e-6))
    assert np.ptp(found - true) < 1e-9


def test_directions_that_are_not_known_wind_no_turn():
    """Thirteen frames with head and tail exchanged, stated with 4 rad, as a labelled film had."""
    true = np.full(200, 1.25)
    shown, variance = true.copy(), np.full(200, 2e-5)
    shown[90:103] = np.linspace(1.0, 1.25 - 2 * np.pi, 13)
    variance[90:103] = 16.0
    found = unwrapped_angles(np.angle(np.exp(1j * shown)), variance)
    others = np.setdiff1d(np.arange(200), np.arange(90, 103))
    assert np.ptp((found - true)[others]) < 1e-9


@pytest.mark.parametrize("rate", [-2.5, -0.4, 0.4, 2.5])
@pytest.mark.parametrize("rows", ["absent", "empty"])
def test_over_a_gap_the_heading_turns_on(rate, rows):
    """Two seconds and a half unseen: up to a whole turn, which the frames at both ends tell."""
    times = np.arange(0.0, 12.0, 1 / 30)
    true, gap = rate * times, (times > 4) & (times < 6.5)
    shown = np.where(gap, np.nan, np.angle(np.exp(1j * true)))
    kept = ~gap if rows == "absent" else np.ones(len(times), dtype=bool)
    found = unwrapped_angles(shown[kept], np.full(kept.sum(), 1e-5), times[kept])
    assert np.ptp((found - true[kept])[np.isfinite(found)]) < 1e-9


@pytest.mark.parametrize("fps", [30, 60, 120])
@pytest.mark.parametrize("beat", [2.0, 3.1, 6.3])
@pytest.mark.parametrize("rate", [0.0, 0.3, 0.8])
def test_the_tail_beat_winds_no_turn_over_a_gap(fps, beat, rate):
    """Swung by 0.2 rad at the tail's beat; 200 gaps of half a second to two and a half."""
    rng = np.random.default_rng(5)
    times = np.arange(0.0, 12.0, 1 / fps)
    for _ in range(200):
        first, long = rng.uniform(1, 8), rng.uniform(0.5, 2.5)
        true = rate * times + 0.2 * np.sin(2 * np.pi * beat * times + rng.uniform(0, 6.3))
        shown = np.angle(np.exp(1j * (true + rng.normal(0, 5e-3, len(times)))))
        shown[(times > first) & (times < first + long)] = np.nan
        found = unwrapped_angles(shown, np.full(len(times), 2.5e-5), times)
        assert np.ptp((found - true)[np.isfinite(found)]) < 0.5


def test_a_poorly_stated_beginning_keeps_its_turns():
    times = np.arange(0.0, 10.0, 1 / 30)
    true = 2.5 * times
    noise = np.random.default_rng(2).normal(0, 0.3, len(times)) * (times < 3)
    found = unwrapped_angles(
        np.angle(np.exp(1j * (true + noise))), np.where(times < 3, 0.3, 1e-5), times
    )
    assert np.ptp(found - true) < 3.0


def test_unwrapping_bears_few_frames_and_unknown_variances():
    nan = np.nan
    assert unwrapped_angles(np.array([nan, nan]), np.ones(2)) == pytest.approx(
        [nan, nan], nan_ok=True
    )
    assert unwrapped_angles(np.array([3.0, -3.0]), np.array([nan, 1.0])) == pytest.approx(
        [3.0, 2 * np.pi - 3.0]
    )


@pytest.mark.parametrize("phi", [-2.0, -0.7, 0.0, 0.7, 2.0])
def test_head_angle_is_core_minus_head(phi):
    pose = rigid_pose(keypoint_positions(circle_poses(phi=phi)), ROBOT, HEAD_M)
    assert np.allclose(pose.values[:, 3], phi, atol=1e-9)


@pytest.mark.parametrize("stated", [True, False])
def test_pulls_have_unit_width(stated):
    expected = circle_poses(n=1500)
    pulls = []
    for seed in range(4):
        given = keypoint_positions(expected, 0.0012, stated=stated, seed=seed)
        pose = rigid_pose(given, ROBOT, HEAD_M)
        miss = pose.values - expected
        miss[:, 2] = (miss[:, 2] + np.pi) % (2 * np.pi) - np.pi
        pulls.append(miss / np.sqrt(np.diagonal(pose.cov, axis1=1, axis2=2)))
    width = np.std(np.concatenate(pulls), axis=0)
    assert np.all((width > 0.93) & (width < 1.07)), width
    assert np.all(np.abs(np.mean(np.concatenate(pulls), axis=0)) < 0.08)


def test_whole_covariance_has_the_right_shape():
    expected = circle_poses(n=4000, turns=0.0)
    pose = rigid_pose(keypoint_positions(expected, 0.001), ROBOT, HEAD_M)
    found = np.cov((pose.values - expected).T)
    root = np.linalg.inv(np.linalg.cholesky(pose.cov.mean(axis=0)))
    assert np.allclose(root @ found @ root.T, np.eye(4), atol=0.12)


def test_unstated_noise_is_found_part_by_part():
    given = keypoint_positions(circle_poses(n=2000), 0.0005)
    rng = np.random.default_rng(8)
    noisy = given.xy_m.copy()
    noisy[:, 2] += rng.normal(0, 0.003, noisy[:, 2].shape)
    unknown = changed_frames(given, xy_m=noisy, cov_m2=np.full_like(given.cov_m2, np.nan))
    poor = rigid_pose(
        changed_frames(unknown, cov_m2=np.zeros_like(noisy)[..., None] + np.eye(2) * 1e-6),
        ROBOT,
        HEAD_M,
    )
    pose = rigid_pose(unknown, ROBOT, HEAD_M)
    error = np.std(pose.values[:, :2] - circle_poses(n=2000)[:, :2])
    assert error < 0.6 * np.std(poor.values[:, :2] - circle_poses(n=2000)[:, :2])


def test_scale_error_does_not_bend_the_angles():
    expected = circle_poses()
    pose = rigid_pose(keypoint_positions(expected, scale=1.03), ROBOT, HEAD_M)
    assert np.allclose(pose.values[:, 3], expected[:, 3], atol=1e-9)
    assert np.allclose(pose.values[:, :2], 1.03 * expected[:, :2], atol=1e-9)
    assert any("hinge to head_tip measures 123.6 mm" in remark for remark in pose.remarks)


@pytest.mark.parametrize("lost", ["hinge", "core_center", "tail_base"])
def test_a_part_missing_for_a_while_changes_nothing(lost):
    expected, given = circle_poses(), keypoint_positions(circle_poses())
    likelihood = given.likelihood.copy()
    likelihood[100:200, BODY_PART_NAMES.index(lost)] = 0.3
    pose = rigid_pose(changed_frames(given, likelihood=likelihood), ROBOT, HEAD_M)
    assert np.allclose(pose.values[:, [0, 1, 3]], expected[:, [0, 1, 3]], atol=1e-9)
    assert np.all(np.isfinite(pose.cov))


def test_a_core_centre_never_seen_follows_from_the_robot():
    given = keypoint_positions(circle_poses(), scale=1.02)
    keep = [0, 1, 3]
    names = tuple(BODY_PART_NAMES[i] for i in keep)
    fewer = KeypointPositions(
        given.time_s, names, given.xy_m[:, keep], given.cov_m2[:, keep], given.likelihood[:, keep]
    )
    pose = rigid_pose(fewer, ROBOT, HEAD_M)
    assert np.allclose(pose.values[:, :2], 1.02 * circle_poses()[:, :2], atol=1e-9)


def test_frames_without_enough_points_are_nan_and_counted():
    given = keypoint_positions(circle_poses())
    xy = given.xy_m.copy()
    xy[10:15, 0] = np.nan
    xy[20:22, 1:3] = np.nan
    pose = rigid_pose(changed_frames(given, xy_m=xy), ROBOT, HEAD_M)
    lost = np.r_[10:15, 20:22]
    assert np.isnan(pose.values[lost]).all()
    assert np.isfinite(np.delete(pose.values, lost, axis=0)).all()
    assert "pose: 7 of 300 frames lack keypoints" in pose.remarks


@pytest.mark.parametrize("part", ["hinge", "core_center", "tail_base"])
def test_a_confident_wrong_point_is_left_out(part):
    expected, given = circle_poses(), keypoint_positions(circle_poses(), 0.0005)
    xy = given.xy_m.copy()
    xy[50:60, BODY_PART_NAMES.index(part)] += [0.05, -0.04]
    pose = rigid_pose(changed_frames(given, xy_m=xy), ROBOT, HEAD_M)
    assert np.abs(pose.values[50:60, :2] - expected[50:60, :2]).max() < 0.004
    assert any("left out in 10 frames" in remark for remark in pose.remarks)


@pytest.mark.parametrize("stated", [True, False])
@pytest.mark.parametrize("offset_m", [0.008, -0.014])
def test_a_point_always_marked_beside_its_place_bends_all_frames_alike(offset_m, stated):
    expected = circle_poses(phi=0.0)
    given = keypoint_positions(expected, 0.0012, stated=stated)
    psi = expected[:, 2]
    beside = offset_m * np.column_stack([-np.sin(psi), np.cos(psi)])
    xy = given.xy_m.copy()
    xy[:, BODY_PART_NAMES.index("core_center")] += beside
    pose = rigid_pose(changed_frames(given, xy_m=xy), ROBOT, HEAD_M)
    bend = np.unwrap(pose.values[:, 2]) - psi
    bend -= 2 * np.pi * np.round(np.median(bend) / (2 * np.pi))
    # least squares turn the axis of hinge, core centre and tail base (40, 0 and -171 mm) by
    # sideways * 43.7 mm / 25 130 mm2
    assert np.median(bend) == pytest.approx(offset_m * 0.0437 / 0.02513, abs=0.002)
    assert np.std(bend) < 0.012
    assert any("core_center" in r and "marked in the wrong place" in r for r in pose.remarks)
    assert not any("left out" in r for r in pose.remarks)


def test_a_point_that_wanders_is_not_taken_for_one_beside_its_place():
    expected = circle_poses()
    given = keypoint_positions(expected, 0.0012)
    xy = given.xy_m.copy()
    xy[:, BODY_PART_NAMES.index("core_center")] += np.random.default_rng(3).normal(
        0, 0.02, (300, 2)
    )
    pose = rigid_pose(changed_frames(given, xy_m=xy), ROBOT, HEAD_M)
    assert not any("marked in the wrong place" in r for r in pose.remarks)
    assert any("left out" in r for r in pose.remarks)


def test_a_trial_without_a_head_is_a_fault():
    given = keypoint_positions(circle_poses(n=50))
    likelihood = given.likelihood.copy()
    likelihood[:, 0] = 0.1
    with pytest.raises(InputError, match=r"head_tip in 0.*of 50 frames.*bodyparts"):
        rigid_pose(changed_frames(given, likelihood=likelihood), ROBOT, HEAD_M)
