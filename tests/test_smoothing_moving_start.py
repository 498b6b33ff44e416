"""The first frame: trials that begin while the robot swims, and trials that begin at rest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bluekoi.camera import map_keypoints, pool_camera
from bluekoi.data import Pose
from bluekoi.keypoints.deeplabcut import read_keypoints_of_trial
from bluekoi.pose import rigid_pose
from bluekoi.smoothing import smooth_pose
from bluekoi.study import load_study
from bluekoi.synthetic.synthetic_study_design import demo_design
from bluekoi.synthetic.trial import frame_truth, solve_trial
from exact_motions import frame_times, gaining_speed, observed_pose
from validation.generators.campus_pool import generate


@pytest.fixture(scope="module")
def first_speeds(tmp_path_factory: pytest.TempPathFactory) -> tuple[np.ndarray, np.ndarray]:
    """Measured and true speed in the first frame of nine trials, m/s."""
    folder = tmp_path_factory.mktemp("swimming")
    truth = generate(2, 44, folder)["conditions"]
    study = load_study(folder / "studies" / "campus_pool-2-044")
    camera, depth = pool_camera(study.setup), study.setup.robot.keypoint_depth_m
    found = []
    for trial, hz in zip(study.trials, truth["flap_hz"], strict=True):
        labels = read_keypoints_of_trial(Path(study.paths(trial)[0]), trial)
        pose = rigid_pose(
            map_keypoints(camera, labels, depth), study.setup.robot, trial.head_length_m
        )
        found.append(float(smooth_pose(pose, hz).speed_m_s[0]))
    return np.array(found), np.hypot(*np.array(truth["start"])[:, 3:5].T)


def test_most_robots_that_swim_in_the_first_frame_are_not_taken_to_be_at_rest(
    first_speeds: tuple[np.ndarray, np.ndarray],
) -> None:
    """A burst of force in the first frames explained half of such starts; it still explains those
    whose speed grows most.
    """
    found, true = first_speeds
    swims = true > 0.1
    right = np.isclose(found[swims], true[swims], rtol=0.25)
    assert swims.sum() >= 5
    assert right.mean() >= 0.75


def test_a_robot_at_rest_in_the_first_frame_is_at_rest(
    first_speeds: tuple[np.ndarray, np.ndarray],
) -> None:
    found, true = first_speeds
    assert np.all(found[true == 0] < 0.05)


def test_a_robot_that_gains_speed_in_the_first_frame_has_the_speed_of_that_frame() -> None:
    """Its acceleration was taken to be zero there: 0.013 m/s too fast on average."""
    errors = []
    for seed in range(8):
        motion = gaining_speed(frame_times(150))
        track = smooth_pose(observed_pose(motion, np.random.default_rng(seed)), 2.4)
        errors.append(track.speed_m_s[0] - motion.speed[0])
    assert abs(np.mean(errors)) < 0.004
    assert np.sqrt(np.mean(np.square(errors))) < 0.005


def test_a_quick_start_from_rest_is_no_motion_in_the_first_frame() -> None:
    """The search of the noise ended at a poor optimum for a start from rest: one of these four
    began at 0.15 rad/s, and two of them at more than 0.005 m/s.
    """
    truth = frame_truth(demo_design(), solve_trial(demo_design(), "T22"))
    true = np.column_stack([truth["pose"], truth["head_angle_rad"]])
    std = np.array([1e-4, 1e-4, 7e-4, 1.4e-3])
    cov = np.tile(np.diag(std**2), (len(true), 1, 1))
    for seed in range(4):
        noise = std * np.random.default_rng(seed).standard_normal(true.shape)
        track = smooth_pose(Pose(truth["time_s"], true + noise, cov), flap_hz=5.846)
        assert abs(track.yaw_rate_rad_s[0]) < 0.01
        assert track.speed_m_s[0] < 0.01
