"""The tank `wake_memory`: dynamics, optics, detector, composition, files."""

import collections
import json
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from validation.generators.wake_memory import camera, noise, observation, plan, studies
from validation.generators.wake_memory import detector as det
from validation.generators.wake_memory import dynamics as dy
from validation.generators.wake_memory.catalogue import MEASUREMENT, PHYSICS

ROBOT = np.array([0.68, 0.0095, 0.331, 0.12, 0.069, 0.04, 0.066, 4.5e-3, 0.5, 2.5, 3.14, 0.1, 0.12])
NO_EFFECTS = np.zeros((25, 5))


def trial(phi=0.0, f=5.82, pulse=0.0):
    return np.array([phi, f, 0.12, 0.0, 0.5, pulse, 2.0])


def simulated_path(row, E=NO_EFFECTS, seconds=8.0, substeps=16):
    gust = np.zeros((int(seconds * 30), 3))
    return dy.simulate_trial(row, ROBOT, E, np.array([1.3, 0.8, 0.0]), gust, 30.0, substeps)[0]


def test_terminal_speed_is_that_of_the_paper():
    path = simulated_path(trial())
    assert path[-1, 3] == pytest.approx(5.82 * np.sqrt(4.5e-3 / 0.5), rel=1e-3)


def test_start_up_follows_the_tanh_of_quadratic_drag():
    area, f = 0.12 * 0.069, 5.82
    force, drag = 4.5e-3 * 500 * area * f * f, 0.5 * 500 * area
    final = np.sqrt(force / drag)
    t = np.arange(240) / 30
    assert simulated_path(trial())[:, 3] == pytest.approx(
        final * np.tanh(drag * final * t / 0.68), abs=2e-4
    )


def test_pulsating_thrust_keeps_the_mean_motion():
    calm, beating = simulated_path(trial(0.5)), simulated_path(trial(0.5, pulse=0.5))
    assert np.abs(calm[-1, :2] - beating[-1, :2]).max() < 0.01


def test_positive_head_angle_turns_clockwise_and_mirrors():
    left, right = simulated_path(trial(-0.4)), simulated_path(trial(0.4))
    assert right[-1, 5] < 0 < left[-1, 5]
    assert left[:, 1] - 0.8 == pytest.approx(0.8 - right[:, 1], abs=1e-9)


def test_adams_bashforth_converges():
    fine = simulated_path(trial(0.6), seconds=3, substeps=64)[-1, :6]
    errors = [
        np.abs(simulated_path(trial(0.6), seconds=3, substeps=n)[-1, :6] - fine).max()
        for n in (4, 8)
    ]
    assert errors[1] < errors[0] / 3.5
    assert errors[1] < 1e-4


@pytest.mark.parametrize("seed", range(6))
def test_projection_round_trip(seed):
    rng = np.random.default_rng(seed)
    view = camera.draw_camera(rng, tilted=seed == 2)
    xy = rng.uniform([0, 0], [2.6, 1.6], (80, 2))
    for depth in (0.0, 0.15):
        pixels = camera.project(view, np.column_stack([xy, np.full(80, -depth)]))
        assert camera.pixels_to_pool(view, pixels, depth) == pytest.approx(xy, abs=1e-8)


def test_stated_camera_recovers_the_path():
    rng = np.random.default_rng(3)
    optics, row, path = plan.draw_optics(rng, ()), trial(0.5), simulated_path(trial(0.5))
    times = np.arange(len(path)) / 30
    pixels = observation.keypoint_pixels(
        path, times, row, ROBOT, NO_EFFECTS, optics=optics, errors={}
    )
    seen = observation.apparent_pose(pixels, observation.stated_setup(optics, {}))
    points = observation.body_points(path, row, ROBOT, NO_EFFECTS, times)
    assert seen[:, 0] == pytest.approx(points[:, 2].real, abs=4e-3)
    assert seen[:, 3] == pytest.approx(0.5, abs=0.01)


def test_filter_norm_agrees_with_brute_force():
    """Generalised least squares with the sample covariance of simulated gusts and noise."""
    rng, n, first, draws, tau = np.random.default_rng(0), 36, 20, 800, 1.0
    row, gust, white = trial(0.5), np.array([2e-3, 2e-3, 2e-4]), np.array([1e-3, 1e-3, 5e-3])
    E, pose, still = NO_EFFECTS.copy(), np.array([1.3, 0.8, 0.0]), np.zeros((n, 3))
    E[dy.TRIM, :2] = [1, 2e-3]

    def seen(effects, start, water):
        return dy.simulate_trial(row, ROBOT, effects, start, water, 10.0, 20)[0][first:, :3].ravel()

    base = seen(NO_EFFECTS, pose, still)
    gusts = [noise.ornstein_uhlenbeck(rng, (n, 3), 0.1, tau) * gust for _ in range(draws)]
    scatter = np.array([seen(NO_EFFECTS, pose, water) - base for water in gusts])
    covariance = np.cov(scatter.T) + np.diag(np.tile(white**2, n - first))
    free = [(seen(NO_EFFECTS, pose + 1e-4 * axis, still) - base) / 1e-4 for axis in np.eye(3)]
    for c in range(3):  # a pulse just before the first observation frees the starting rates
        pulse = still.copy()
        pulse[first - 2, c] = gust[c]
        free.append((seen(NO_EFFECTS, pose, pulse) - base) / gust[c])
    root = np.linalg.cholesky(covariance)
    signal = np.linalg.solve(root, seen(E, pose, still) - base)
    brute = det.projected_norm(signal, np.linalg.solve(root, np.array(free).T))
    path, wake = dy.simulate_trial(row, ROBOT, NO_EFFECTS, pose, still, 10.0, 20)
    J, _ = det.block_jacobians(np.arange(n) * 0.1, path, wake, row, ROBOT, NO_EFFECTS)
    d = np.zeros((n - first, 3, 1))
    d[:, 2, 0] = 2e-3 / ROBOT[1]
    tiny = np.full(3, 1e-9)
    out = det.whitened_innovations(
        J[first:], d, 0 * d, 0.1, white, tiny, 1.0, gust, tau, 1e-9, 1e-9
    )
    assert np.linalg.norm(out) == pytest.approx(brute, rel=0.1)


def test_composition_of_any_forty():
    for first in (0, 13):
        chosen = [plan.study_slot(5, i) for i in range(first, first + 40)]
        assert collections.Counter(c[0] for c in chosen) == dict(plan.GROUP_COUNTS)
        assert sum(c[1] % 2 for c in chosen) == 20
        assert sum(c[2] in plan.NINE_TRIALS for c in chosen) == 10


def test_every_name_is_dealt():
    names = {
        n for i in range(80) for n in plan.effect_names_of_study(2, *plan.study_slot(2, i)[:2])
    }
    assert names == {*PHYSICS, *MEASUREMENT, "unlisted"}


def test_study_is_deterministic_and_its_truth_complete(tmp_path):
    index = next(i for i in range(40) if plan.study_slot(4, i)[0] == "unlisted"
                 and plan.study_slot(4, i)[2] in plan.NINE_TRIALS)  # fmt: skip
    one = studies.generate(4, index, tmp_path / "a")
    two = studies.generate(4, index, tmp_path / "b")
    assert json.dumps(one) == json.dumps(two)
    assert one["verdict"] == "unexplained"
    assert 14 <= one["unlisted"]["sigma"] <= 40
    assert one["trials"] == 9
    folder = tmp_path / "a" / "studies" / one["study"]
    for file in sorted(folder.rglob("*.csv")):
        assert file.read_bytes() == (tmp_path / "b" / file.relative_to(tmp_path / "a")).read_bytes()
    assert not list(folder.rglob("*truth*"))
    assert {p.name for p in folder.iterdir()} == {"study.yaml", "trials.csv", "keypoints", "motor"}
