"""Derivatives of the smoother's likelihood, against differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from planar_models import planar_model

from bluekoi.smoothing import noise_fit
from bluekoi.smoothing.grid import filter_time_grid
from bluekoi.smoothing.kalman_numba import filter_pass, minus_two_log_likelihood
from bluekoi.smoothing.likelihood_gradient import likelihood_gradient
from bluekoi.smoothing.state_space_fit import KnownMotion, fit_angle, fit_position
from exact_motions import CameraConditions, circle, frame_times, observed_pose

STEP = 1e-4


@pytest.mark.parametrize("gate", [np.inf, 15.0, 1.5])
@pytest.mark.parametrize("matrix", ["F", "Q", "R", "P0"])
@pytest.mark.parametrize("recoil", [True, False])
def test_derivatives_by_the_matrices_of_a_model_are_those_of_its_likelihood(recoil, matrix, gate):
    model, used = planar_model(recoil)
    rng = np.random.default_rng(2)
    value = getattr(model, matrix)
    change = rng.normal(size=value.shape) * value
    if matrix != "F":
        change = change + np.swapaxes(change, -1, -2)
    step = 1e-7 if matrix == "F" else 1e-5
    ends = [
        minus_two_log_likelihood(
            replace(model, **{matrix: value + sign * step * change}), used, gate
        )
        for sign in (1, -1)
    ]
    found = likelihood_gradient(model, used, gate, filter_pass(model, used, gate))
    slope = float(np.sum(getattr(found, matrix) * change))
    assert slope == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-3)


@pytest.mark.parametrize("hz", [2.37, 0.0])
@pytest.mark.parametrize("resting", [True, False])
@pytest.mark.parametrize("coloured", [True, False])
@pytest.mark.parametrize("planar", [True, False])
def test_derivatives_by_the_noise_are_those_of_the_cost(planar, coloured, resting, hz, monkeypatch):
    truth = circle(frame_times(90))
    pose = observed_pose(truth, np.random.default_rng(1), CameraConditions(gap_s=(0.8, 1.1)))
    grid = filter_time_grid(pose.time_s, hz)
    checked = []

    def compare(cost, start):
        """In place of the search: derivatives at places about its start, and no search."""
        rng = np.random.default_rng(3)
        at = start + rng.normal(size=len(start))
        slope = cost(at)[1]()
        for j, step in enumerate(STEP * np.eye(len(at))):
            difference = (cost(at + step)[0] - cost(at - step)[0]) / (2 * STEP)
            checked.append((len(start), j, slope[j], difference))
        return start, cost(start)[0]

    monkeypatch.setattr(noise_fit, "minimise", compare)
    common = {"flap_hz": hz, "resting": resting, "coloured": coloured}
    speed = np.full(len(grid.time_s), 0.2)
    values, cov = grid.frame_values_on_nodes(pose.values), grid.frame_values_on_nodes(pose.cov)
    if planar:
        known = KnownMotion(values[:, 2], np.full(len(speed), 0.01), 10 * speed, speed)
        known = replace(known, theta=np.interp(grid.time_s, truth.time_s, truth.heading))
        fit_position(values[:, :2], cov[:, :2, :2], grid, known=known, **common)
    else:
        fit_angle(values[:, 2], cov[:, 2, 2], grid, speed=speed, **common)
    assert checked
    if coloured:
        assert len({row[0] for row in checked}) == 2
    for _, j, slope, difference in checked:
        assert slope == pytest.approx(difference, rel=1e-3, abs=1e-3), j
