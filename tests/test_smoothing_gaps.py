"""Over gaps the stated deviations hold: on exact motions, and on fish filmed by others."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from bluekoi.data import Pose
from bluekoi.smoothing import smooth_pose, smoothed_track_and_noise_ratio
from bluekoi.smoothing.gaps import index_ranges_of_true, with_calibrated_gap_covariance
from bluekoi.smoothing.kalman_numba import compiled_filter_and_smooth
from bluekoi.smoothing.linear_gaussian import LinearGaussianModel
from exact_motions import CameraConditions, circle, frame_times, observed_pose, random_turn
from keypoint_files import read_all_parts

PX_M, FPS = 1e-3, 50.0
"""Of fish_film any scale will do; its frame rate is assumed."""
LARVA_M_PER_PX = 0.0222e-3
long_test = pytest.mark.long


def film_fish(recordings) -> list[Pose]:
    """Body centres and directions of 13 fish by another program, px taken as mm."""
    with (recordings / "fish_film" / "tracking.txt").open() as lines:
        rows = [[float(row[name]) for name in ("id", "imageNumber", "xBody", "yBody", "tBody")]
                for row in csv.DictReader(lines, delimiter="\t")]  # fmt: skip
    table = np.array(rows)
    fish = [table[table[:, 0] == i] for i in np.unique(table[:, 0])]
    cov = np.diag([(0.3 * PX_M) ** 2] * 2 + [0.1**2, 1e-4])
    return [
        make_pose(rows[:, 1] / FPS, PX_M * rows[:, 2:4] * [1, -1], rows[:, 4], cov)
        for rows in fish
        if len(rows) > 150
    ]


def larvae(recordings) -> list[Pose]:
    """Seven swimming larvae, 1000 frames/s."""
    cov = np.diag([(1e-5) ** 2] * 2 + [1e-3, 1e-4])
    poses = []
    for path in sorted((recordings / "zebrafish_kinematics" / "dlc").glob("*.csv")):
        found = read_all_parts(path, 1000.0)
        at = [found.names.index(name) for name in ("TS", "S2")]
        snout, middle = (LARVA_M_PER_PX * found.xy_px[:, k] for k in at)
        heading = np.unwrap(np.arctan2(*(snout - middle).T[::-1]))
        poses.append(make_pose(found.time_s, middle, heading, cov))
        poses[-1].values[found.likelihood[:, at].min(axis=1) < 0.6] = np.nan
    return poses


def make_pose(time_s, xy_m, heading, cov) -> Pose:
    values = np.column_stack([xy_m, np.unwrap(heading), np.zeros(len(xy_m))])
    return Pose(time_s, values, np.tile(cov, (len(values), 1, 1)))


def hidden_frames(pose: Pose, gap: int, offset: int) -> np.ndarray:
    """Frames hidden in runs of `gap`, at least 25 frames and two gaps apart."""
    n = len(pose.time_s)
    out = np.zeros(n, bool)
    for first in range(20 + offset, n - gap - 15, gap + max(25, 2 * gap)):
        out[first : first + gap] = True
    return out


def normalised_errors(pose: Pose, gap: int, offset: int) -> np.ndarray:
    """Measured minus interpolated positions over their joint deviation, all hidden frames."""
    away = hidden_frames(pose, gap, offset)
    values = np.where(away[:, None], np.nan, pose.values)
    track, (shown, _) = smoothed_track_and_noise_ratio(Pose(pose.time_s, values, pose.cov), 0.0)
    errors = pose.values[:, :2] - np.column_stack([track.x_m, track.y_m])
    variance = np.column_stack([track.x_m_std, track.y_m_std]) ** 2 + shown * pose.cov[0, 0, 0]
    found = (errors / np.sqrt(variance))[away].ravel()
    return found[np.isfinite(found)]


@pytest.mark.recordings
@pytest.mark.parametrize(
    "gap", [5, pytest.param(10, marks=long_test), pytest.param(20, marks=long_test)]
)
@pytest.mark.parametrize("source", [pytest.param(film_fish, marks=long_test), larvae])
def test_deviations_over_gaps_hold_on_filmed_fish(recordings, source, gap):
    offsets = (0, 11) if source is film_fish else (0, 7, 14, 21)
    poses = source(recordings)
    errors = np.concatenate(
        [normalised_errors(p, gap, offset) for p in poses for offset in offsets]
    )
    assert 0.9 < np.sqrt(np.mean(errors**2)) < 1.2
    assert 0.93 < np.mean(np.abs(errors) < 2) < 0.97


@pytest.mark.parametrize("make", [lambda t, _: circle(t), random_turn])
def test_deviations_over_gaps_hold_on_known_motions(make):
    pulls = []
    for seed in range(8):
        truth = make(frame_times(150), np.random.default_rng([51, seed]))
        pose = observed_pose(
            truth, np.random.default_rng([52, seed]), CameraConditions(5.82, gap_s=(2.0, 2.5))
        )
        track = smooth_pose(pose, 5.82)
        at = np.isnan(pose.values[:, 0])
        pulls.append((track.x_m - truth.xy[:, 0])[at] / track.x_m_std[at])
        pulls.append((track.y_m - truth.xy[:, 1])[at] / track.y_m_std[at])
    assert 0.5 < np.sqrt(np.mean(np.square(pulls))) < 1.4


def random_walk_model(std: float, rng: np.random.Generator) -> LinearGaussianModel:
    """A chain that states steps of deviation 1 where the measured walk has steps of `std`."""
    n, one = 400, np.ones((400, 1, 1))
    z = np.cumsum(rng.normal(0, std, n))[:, None] + rng.normal(0, 0.1, (n, 1))
    return LinearGaussianModel(one, one, one, 0.01 * one, z, np.zeros(1), np.eye(1))


@pytest.mark.parametrize("std", [1.0, 3.0])
def test_the_variance_over_a_gap_becomes_that_of_the_motion(std):
    used = np.ones(400, bool)
    used[100:110], used[300] = False, False
    ratios = []
    for seed in range(5):
        chain = random_walk_model(std, np.random.default_rng([53, seed]))
        state = compiled_filter_and_smooth(chain, used)
        calibrated = with_calibrated_gap_covariance(chain, used, state, 1)
        outside = np.arange(400) // 10 != 10
        assert calibrated.P[outside] == pytest.approx(state.P[outside])
        ratios.append(calibrated.P[105, 0, 0] / state.P[105, 0, 0])
    assert np.mean(ratios) == pytest.approx(1.5 * std**2, rel=0.5)


def test_runs_of_a_mask():
    assert index_ranges_of_true(np.array([True, False, True, True])) == [(0, 1), (2, 4)]
