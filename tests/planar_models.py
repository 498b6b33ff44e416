"""Linear Gaussian models of a planar motion with gaps, for tests of the filter."""

from __future__ import annotations

import numpy as np

from bluekoi.smoothing.linear_gaussian import LinearGaussianModel
from bluekoi.smoothing.motion import planar_matrices, planar_observation_matrix
from exact_motions import CameraConditions, circle, frame_times, observed_pose

PLANAR_NOISE = np.array([0.8, 1e-3, 5e-2, 2.0, 0.3, 1e-5, 2e-6, 20.0, 0.5])


def planar_model(recoil: bool) -> tuple[LinearGaussianModel, np.ndarray]:
    """A planar chain with a lively noise, gaps among its measurements."""
    hz = 2.37 if recoil else 0.0
    truth = circle(frame_times(60))
    pose = observed_pose(truth, np.random.default_rng(1), CameraConditions(gap_s=(0.8, 1.1)))
    dt = np.diff(pose.time_s, prepend=pose.time_s[0])
    course = np.column_stack([np.exp(-pose.time_s), np.tile([0.7, 1e-4], (60, 1))])
    F, Q = planar_matrices(PLANAR_NOISE, dt, hz, course, truth.heading)
    d = F.shape[1]
    used = np.isfinite(pose.values[:, 0])
    z = np.where(used[:, None], pose.values[:, :2], 0.0)
    H = planar_observation_matrix(truth.heading, hz)
    P0 = np.diag([1.0] * 2 + [0.3] * 4 + [1e-5] * (d - 6))
    return LinearGaussianModel(F, Q, H, pose.cov[:, :2, :2], z, np.zeros(d), P0), used
