"""The compiled twin against filterpy, the motion model against its own differential equation."""

from __future__ import annotations

import numpy as np
import pytest
from planar_models import PLANAR_NOISE, planar_model
from scipy.linalg import expm

from bluekoi.data import BoolNDArray
from bluekoi.smoothing import kalman_numba
from bluekoi.smoothing.coloured_noise import with_coloured_noise
from bluekoi.smoothing.grid import filter_time_grid
from bluekoi.smoothing.kalman_filterpy import (
    _new_kalman_filter,
    _predict_and_update,
    filter_and_smooth,
)
from bluekoi.smoothing.linear_gaussian import LinearGaussianModel, SmoothedStates
from bluekoi.smoothing.motion import heading_matrices, planar_matrices
from bluekoi.smoothing.nominal_motion import nominal_motion_without_onset, rough_speed
from bluekoi.smoothing.quasi_newton import minimise
from exact_motions import CameraConditions, frame_times, observed_pose, start_from_rest

NOISE = np.array([0.8, 1e-3, 5e-2, 2.0, 1e-5, 20.0, 0.5])


def filterpy_smoother(model: LinearGaussianModel, used: BoolNDArray) -> SmoothedStates:
    """The same by filterpy's own smoother, for chains whose process noise is not singular.

    Source: Rauch, Tung, Striebel, AIAA Journal 3 (1965) 1445, eqs. 3.28 to 3.31.
    """
    n, _, d = model.H.shape
    kf = _new_kalman_filter(model)
    means, covs = np.empty((n, d)), np.empty((n, d, d))
    for k in range(n):
        _predict_and_update(kf, model, k, bool(used[k]))
        means[k], covs[k] = kf.x, kf.P
    x, P, _, _ = kf.rts_smoother(means, covs, list(model.F), list(model.Q))
    return SmoothedStates(np.asarray(x), np.asarray(P))


@pytest.mark.parametrize("recoil", [True, False])
def test_twin_is_filterpy(recoil):
    chain, used = planar_model(recoil)
    ours, theirs, mixed = (
        kalman_numba.compiled_filter_and_smooth(chain, used),
        filterpy_smoother(chain, used),
        filter_and_smooth(chain, used),
    )
    scale = np.sqrt(np.einsum("nii->ni", theirs.P))
    for found in (ours, mixed):
        assert np.abs((found.x - theirs.x) / scale).max() < 1e-5
        assert np.abs(np.einsum("nii->ni", found.P) / scale**2 - 1).max() < 1e-5


def test_likelihood_is_that_of_the_joint_normal():
    """-2 log N(z; 0, C) with C built from the chain without any filter."""
    chain, used = planar_model(recoil=False)
    n, d = 8, 6
    step = np.zeros((n * d, n * d))
    cov = np.zeros((n * d, n * d))
    for k in range(n):
        at = slice(k * d, (k + 1) * d)
        step[at, at] = np.eye(d)
        cov[at, at] = chain.P0 if k == 0 else chain.Q[k]
        for j in range(k):
            before = slice(j * d, (j + 1) * d)
            last = slice((k - 1) * d, k * d)
            step[at, before] = chain.F[k] @ step[last, before]
    full = step @ cov @ step.T
    H = np.zeros((2 * n, n * d))
    R = np.zeros((2 * n, 2 * n))
    for k in range(n):
        H[2 * k : 2 * k + 2, k * d : (k + 1) * d] = chain.H[k]
        R[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = chain.R[k]
    S = H @ full @ H.T + R
    z = chain.z[:n].ravel()
    expected = np.linalg.slogdet(2 * np.pi * S)[1] + z @ np.linalg.solve(S, z)
    part = LinearGaussianModel(*(getattr(chain, k)[:n] for k in "FQHRz"), chain.x0, chain.P0)
    assert kalman_numba.minus_two_log_likelihood(part, used[:n], np.inf) == pytest.approx(
        expected, rel=1e-8
    )


def test_motion_without_process_noise_is_smoothed():
    """filterpy's own smoother inverts a singular matrix here."""
    chain, used = planar_model(recoil=True)
    exact = LinearGaussianModel(
        chain.F, 1e-22 * chain.Q, chain.H, chain.R, chain.z, chain.x0, chain.P0
    )
    found = filter_and_smooth(exact, used)
    assert np.isfinite(found.x).all()
    assert (np.einsum("nii->ni", found.P) > 0).all()


def test_mean_motion_solves_its_differential_equation():
    tau, dt = 0.8, 0.033
    F, Q = heading_matrices(NOISE, np.array([0.0, dt]), 0.0, nominal_motion_without_onset(2))
    A = np.array([[0, 1, 0], [0, 0, 1], [0, 0, -1 / tau]])
    assert F[1] == pytest.approx(expm(A * dt), abs=1e-12)
    fine = np.linspace(0, dt, 4001)
    density = np.diag([0.0, NOISE[1], NOISE[2]])
    flow = np.array([expm(A * s) for s in fine[::40]])
    inside = np.einsum("nij,jk,nlk->nil", flow, density, flow)
    expected = np.trapezoid(inside, fine[::40], axis=0)
    # Q leaves out that the acceleration dies out within the step: right to dt / tau
    assert Q[1] == pytest.approx(expected, rel=1.1 * dt / tau, abs=1e-12)


def test_a_steady_turn_is_exact_over_one_step():
    """Surge and sway constant, heading turning: the step ends on the circle."""
    w, dt, speed = 1.5, 0.05, 0.4
    theta = np.array([0.3, 0.3 + w * dt])
    F, _ = planar_matrices(
        PLANAR_NOISE, np.array([0.0, dt]), 0.0, nominal_motion_without_onset(2), theta
    )
    state = np.array([0.0, 0.0, speed, 0.0, 0.0, 0.0])
    radius = speed / w
    expected = radius * np.array(
        [np.sin(theta[1]) - np.sin(theta[0]), np.cos(theta[0]) - np.cos(theta[1])]
    )
    assert (F[1] @ state)[:2] == pytest.approx(expected, abs=1e-12)


def test_a_start_against_quadratic_drag_needs_no_process_noise():
    """v = v_inf tanh(t / tau) has a' = -(2 tanh(t / tau) / tau) a: pace tanh, time tau / 2."""
    t = frame_times(200)
    truth = start_from_rest(t, final=0.38, tau=0.9, heading=0.0)
    dt = np.diff(t, prepend=t[0])
    pace = np.append(0.0, np.diff(np.log(np.cosh(t / 0.9))) * 0.9 / dt[1:])
    course = np.column_stack([np.zeros(200), np.maximum(pace, 1e-9), np.zeros(200)])
    noise = np.array([0.45, 0.0, 0.0, 0.0, 1.0])
    F, _ = planar_matrices(noise, dt, 0.0, course, np.zeros(200))
    state = np.array([*truth.xy[0], 0.0, 0.0, 0.38 / 0.9, 0.0])
    for k in range(1, 200):
        state = F[k] @ state
        assert state[0] == pytest.approx(truth.xy[k, 0], abs=4e-4)
        assert state[2] == pytest.approx(truth.speed[k], abs=4e-4)


def test_noise_of_surge_and_sway_turns_with_the_body():
    """Heading along y: what disturbs surge moves y, and sway's share of it moves x."""
    course = nominal_motion_without_onset(2)
    course[:, 2] = 1e-3
    dt, theta = np.array([0.0, 0.05]), np.full(2, np.pi / 2)
    _, Q = planar_matrices(PLANAR_NOISE, dt, 0.0, course, theta)
    _, along = heading_matrices(NOISE, dt, 0.0, nominal_motion_without_onset(2))
    assert Q[1, 1, 1] == pytest.approx(along[1, 0, 0])
    assert Q[1, 3, 3] == pytest.approx(0.3 * along[1, 1, 1] + 1e-3 * 0.05, rel=1e-9)
    assert Q[1, 0, 0] == pytest.approx(Q[1, 3, 3] * 0.05**2 / 3, rel=0.01)
    assert np.linalg.eigvalsh(Q[1]).min() > -1e-15


def test_rough_speed_follows_a_start_and_no_tail_beat():
    truth = start_from_rest(frame_times(150))
    pose = observed_pose(
        truth, np.random.default_rng(4), CameraConditions(hz=5.82, gap_s=(2.0, 2.3))
    )
    grid = filter_time_grid(pose.time_s, 5.82)
    found = rough_speed(
        grid.frame_values_on_nodes(pose.values[:, :2]),
        grid.frame_values_on_nodes(pose.cov[:, :2, :2]),
        grid,
    )
    assert np.abs(found[grid.frame] - truth.speed).max() < 0.08


def test_errors_that_last_are_correlated_as_stated():
    """cov(e_j, e_k) = variance exp(-|t_j - t_k| / T), through the chain's own matrices."""
    chain, _ = planar_model(recoil=False)
    dt = np.diff(frame_times(60), prepend=0.0)
    longer = with_coloured_noise(chain, dt, 4e-6, 0.1)
    assert longer.H.shape == (60, 2, 8)
    assert longer.H[5, 0] @ np.array([1, 0, 0, 0, 0, 0, 3, 0]) == 4
    P, at = longer.P0, slice(6, 8)
    for k in range(1, 60):
        P = longer.F[k] @ P @ longer.F[k].T + longer.Q[k]
    assert P[at, at] == pytest.approx(4e-6 * np.eye(2))
    across = longer.F[7, 6, 6] * longer.F[6, 6, 6]
    assert across == pytest.approx(np.exp(-2 * dt[6] / 0.1))


def test_recoil_keeps_its_variance():
    _, Q = heading_matrices(NOISE, np.full(400, 0.033), 2.37, nominal_motion_without_onset(400))
    F, _ = heading_matrices(NOISE, np.full(400, 0.033), 2.37, nominal_motion_without_onset(400))
    P = NOISE[4] * np.eye(2)
    for k in range(1, 400):
        P = F[k, 3:, 3:] @ P @ F[k, 3:, 3:].T + Q[k, 3:, 3:]
    assert pytest.approx(NOISE[4] * np.eye(2), rel=1e-9, abs=1e-15) == P


def test_recoil_loses_its_phase_over_the_stated_beats():
    """Kept over b beats: exp(-b / coherence), at the onset exp(-b (1 / coherence + decay rate))."""
    hz, dt, beats = 2.0, np.array([0.0, 0.05]), 0.1
    steady = nominal_motion_without_onset(2)
    onset = steady.copy()
    onset[:, 0] = 1.0
    for nominal, per_beat in ((steady, 1 / 35), (onset, 1 / 35 + 0.5)):
        F, Q = heading_matrices(NOISE, dt, hz, nominal)
        keep = np.exp(-beats * per_beat)
        turn = np.array([[np.cos(0.2 * np.pi), -np.sin(0.2 * np.pi)],
                         [np.sin(0.2 * np.pi), np.cos(0.2 * np.pi)]])  # fmt: skip
        assert F[1, 3:, 3:] == pytest.approx(keep * turn)
        assert Q[1, 3:, 3:] == pytest.approx(NOISE[4] * (1 - keep**2) * np.eye(2))
        F, Q = planar_matrices(PLANAR_NOISE, dt, hz, nominal, np.zeros(2))
        for at, variance in ((6, PLANAR_NOISE[5]), (8, PLANAR_NOISE[6])):
            assert F[1, at : at + 2, at : at + 2] == pytest.approx(keep * turn)
            assert Q[1, at, at] == pytest.approx(variance * (1 - keep**2))


def test_grid_has_nodes_where_frames_are_far_apart():
    t = np.array([0.0, 1.0, 2.0, 6.0, 7.0])
    grid = filter_time_grid(t, 0.0)
    assert grid.time_s[grid.frame] == pytest.approx(t)
    assert grid.dt_s.max() <= 1.5
    assert np.isnan(grid.frame_values_on_nodes(t)[~grid.frame]).all()
    assert filter_time_grid(np.arange(20) / 30, 2.37).scale_s == pytest.approx(1 / 2.37)


def test_descent_finds_the_minimum_of_a_narrow_bowl():
    bowl = np.array([[60.0, 20.0, 0.0], [20.0, 10.0, 1.0], [0.0, 1.0, 1.0]])
    middle = np.array([0.5, -1.0, 2.0])

    def cost(at):
        away = at - middle
        value = 7.0 + away @ bowl @ away + 0.5 * away[2] ** 4
        return value, lambda: 2.0 * bowl @ away + [0.0, 0.0, 2.0 * away[2] ** 3]

    place, value = minimise(cost, np.array([4.0, 4.0, -4.0]), enough=1e-3, steps=60)
    assert place == pytest.approx(middle, abs=0.05)
    assert value == pytest.approx(7.0, abs=0.02)
