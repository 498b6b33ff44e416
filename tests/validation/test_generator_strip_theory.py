"""The strip-theory tank: dynamics by hand formulas, optics there and back, composition, truth."""

import json
import math
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

sys.path.insert(0, str(Path(__file__).parents[2]))

from validation.generators.strip_theory import camera as cam
from validation.generators.strip_theory import detector, effects, optics, studies, tank, water
from validation.generators.strip_theory.noise import draw_noise
from validation.generators.strip_theory.parameters import KEYS


def robot(seed=0):
    return studies.draw_robot(np.random.default_rng(seed))


def trial(P, command=0.0, duration=12.0, fps=30.0, modes=None):
    modes = tank.NO_WATER_MOTION if modes is None else modes
    return tank.Trial("T01", 0, 100.0, command, P[KEYS.HEAD_1X], fps, duration, 5.0, 0.0, 0.0, 0.0,
                      modes, 24, (1.3, 0.8, 0.3))  # fmt: skip


def test_terminal_speed_is_f_sqrt_of_thrust_over_drag():
    P = robot()
    run = tank.run_trial(trial(P), P)
    speed = np.hypot(*run.Y[-1, 2:4])
    assert speed == pytest.approx(5.0 * math.sqrt(P[KEYS.C_T] / P[KEYS.C_D0]), rel=1e-4)


def test_positive_head_angle_turns_clockwise_and_mirrors():
    P = robot()
    right, left = (tank.run_trial(trial(P, a), P).Y[-1, 5] for a in (0.5, -0.5))
    assert right < -0.2
    assert left == pytest.approx(-right, rel=1e-9)


def test_halving_the_step_changes_little():
    P = robot()
    studies.add_fin(P, np.random.default_rng(3))
    coarse = tank.run_trial(trial(P, 0.5, 5.0, 30.0), P).Y[-1, :5]
    fine = tank.run_trial(trial(P, 0.5, 5.0, 240.0), P).Y[-1, :5]
    assert np.allclose(coarse, fine, atol=1e-4)


def test_crossflow_takes_energy_and_added_mass_keeps_it():
    P = robot()
    P[[KEYS.C_LA, KEYS.C_DA, KEYS.C_D0, KEYS.C_MA, KEYS.C_MD]] = 0.0
    start = trial(P, 0.0, 2.0, 60.0)
    start = replace(start, flap_hz=0.0)
    P[KEYS.AM_FORM], P[KEYS.AM_SHARE] = 1, 1.0
    dt, sub, phi, freq = tank.input_series(start, P, 121)
    y0 = np.array([0, 0, 0.3, 0.1, 0.2, 1.0, 0, 0])
    own = tank.trial_parameters(P, start)
    Y, _ = tank.simulate(y0, dt, sub, phi, freq, own, tank.NO_WATER_MOTION)
    A11, A22, A26, A66 = tank_added_mass(own)
    v = (Y[:, 2] + 1j * Y[:, 3]) * np.exp(-1j * Y[:, 4])
    r = Y[:, 5]
    energy = 0.5 * ((P[KEYS.MASS] + A11) * v.real**2 + (P[KEYS.MASS] + A22) * v.imag**2)
    energy += A26 * v.imag * r + 0.5 * (P[KEYS.INERTIA] + A66) * r**2
    assert np.ptp(energy) < 1e-4 * energy[0]
    own[KEYS.AM_SHARE], own[KEYS.CROSS_FORM], own[KEYS.CROSS_CD] = 0.0, 1, 1.0
    Y, _ = tank.simulate(y0, dt, sub, phi, freq, own, tank.NO_WATER_MOTION)
    energy = P[KEYS.MASS] * np.hypot(Y[:, 2], Y[:, 3]) ** 2 + P[KEYS.INERTIA] * Y[:, 5] ** 2
    assert (np.diff(energy) <= 0).all()


def tank_added_mass(P):
    from validation.generators.strip_theory.dynamics import added_mass

    return added_mass(P)


def test_fin_area_gives_the_growth_rate_asked_for():
    P = robot()
    assert tank.straight_growth_rate(P, 5.8) > 1.0
    P[KEYS.FIN_FORM], P[KEYS.FIN_ASPECT] = 1, 1.0
    P[KEYS.FIN_AREA] = tank.fin_area_for(P, 5.8, -0.5, (1e-4, 0.05))
    assert tank.straight_growth_rate(P, 5.8) == pytest.approx(-0.5, abs=0.02)


@pytest.mark.parametrize("plain", [True, False])
def test_projection_round_trip_through_lens_and_water(plain):
    rng = np.random.default_rng(4)
    for _ in range(4):
        camera = cam.draw_camera(rng, (2.6, 1.6), plain, 1.333)
        xy = rng.uniform(0.1, 0.9, (50, 2)) * (2.6, 1.6)
        pixels = cam.project(camera, np.column_stack([xy, np.full(50, -0.05)]))
        assert (pixels > 0).all()
        assert (pixels < camera.size).all()
        assert np.allclose(cam.pixels_to_pool(camera, pixels, 0.05), xy, atol=1e-6)


def test_refraction_obeys_snell():
    R, H, d, n = np.array([1.0]), 2.0, np.array([0.2]), 1.333
    r = cam.surface_radius(R, H, d, n)
    above, below = r / np.hypot(r, H), (R - r) / np.hypot(R - r, d)
    assert above == pytest.approx(n * below, rel=1e-9)


def test_forty_indices_hold_the_whole_composition():
    places = [studies.study_slot(k) for k in range(13, 53)]
    assert Counter(p.group for p in places) == dict(studies.GROUPS)
    assert sum(p.trials == 9 for p in places) == 10
    for group, size in studies.GROUPS:
        assert sum(p.fin for p in places if p.group == group) == size // 2


def test_every_cause_is_drawn_about_equally_often():
    drawn = Counter(c for k in range(200) for c in studies.hidden_causes(3, k))
    for causes in (effects.PHYSICS_CAUSES, effects.MEASUREMENT_CAUSES):
        counts = [drawn[cause] for cause in causes]
        assert min(counts) >= max(counts) - 1
    assert len(effects.PHYSICS_CAUSES) == 23
    assert len(effects.MEASUREMENT_CAUSES) == 7
    assert all(len(effects.forms_of(c)) >= 2 for c in drawn if effects.forms_of(c))


def test_sigma_equals_that_of_full_covariance():
    """Brute force: whole trials in Monte Carlo water, plain covariance, no coefficients."""
    rng = np.random.default_rng(8)
    P = robot(2)
    studies.add_fin(P, np.random.default_rng(3))
    noise = replace(draw_noise(rng), white_px=0.6, correlated_px=0.3, correlation_s=0.1,
                    water_rms_m_s=1e-3)  # fmt: skip
    scene = detector.ObservationScene(cam.draw_camera(rng, (2.6, 1.6), True, 1.333), 0.03, noise)
    P[KEYS.YAW_FORM], P[KEYS.YAW_LIN] = 1, 1e-3
    form = effects.forms_of("linear_yaw_damping")[0]
    base = trial(P, 0.5, 4.0)
    run = tank.run_trial(base, P)
    frames = np.arange(0, 120, 6)
    D, G = np.zeros((20, 3, 7)), detector.block_changes(run, run.Y[frames], [form])
    E = detector.whitened_innovations(
        run, scene, G, D, detector.block_jacobians(run, run.Y[frames])
    )
    filtered = np.linalg.norm(E[:, 6])

    def path(P_, **change):
        return tank.run_trial(replace(base, **change), P_).Y[frames][:, [0, 1, 4]].ravel()

    change = path(P) - path(form.without(P))
    draws = np.array([
        path(P, modes=water.random_modes(rng, studies.POOL, 1e-3),
             servo_error=rng.normal(0, detector.SERVO_STD),
             flap_error=rng.normal(0, detector.FLAP_STD))
        for _ in range(1500)
    ])  # fmt: skip
    white, slow = detector.tracking_variances(run, scene)
    t = frames / 30.0
    a = np.exp(-np.abs(t[:, None] - t) / noise.correlation_s)
    C = np.cov(draws.T) + np.diag(np.tile(white, 20)) + np.kron(a, np.diag(slow))
    Y0 = base.start
    starts = [replace(base, start=tuple(np.add(Y0, 1e-4 * d))) for d in np.eye(3)]
    free = np.stack([(tank.run_trial(s, P).Y[frames][:, [0, 1, 4]].ravel() - path(P)) / 1e-4
                     for s in starts], axis=1)  # fmt: skip
    C += free @ free.T
    assert filtered == pytest.approx(math.sqrt(change @ np.linalg.solve(C, change)), rel=0.3)


@pytest.fixture(scope="module")
def null_study(tmp_path_factory):
    index = next(k for k in range(40) if studies.study_slot(k).group == "null"
                 and studies.study_slot(k).trials == 9)  # fmt: skip
    folder = tmp_path_factory.mktemp("tank")
    return index, folder, studies.generate(5, index, folder)


def test_same_seed_and_index_give_the_same_bytes(null_study, tmp_path):
    index, folder, truth = null_study
    assert studies.generate(5, index, tmp_path) == truth
    for file in sorted((folder / "studies").rglob("*")):
        if file.is_file():
            assert (tmp_path / file.relative_to(folder)).read_bytes() == file.read_bytes()


def test_truth_has_the_agreed_keys(null_study):
    index, folder, truth = null_study
    assert json.loads((folder / "truth" / f"{truth['study']}.json").read_text()) == truth
    keys = (
        "study generator seed index group fin trials verdict causes unlisted noise robot conditions"
    )
    assert set(truth) == set(keys.split())
    assert truth["index"] == index
    assert truth["verdict"] == ("physics" if truth["fin"] else "none")


def test_written_keypoints_give_the_simulated_start(null_study):
    _, folder, truth = null_study
    study = folder / "studies" / truth["study"]
    config = yaml.safe_load((study / "study.yaml").read_text())
    rows = pd.read_csv(study / "trials.csv")
    start = truth["conditions"]["trials"][0]["start"]
    table = pd.read_csv(study / rows.source[0], header=None, low_memory=False)
    assert len(rows) == 9
    lens = truth["conditions"]["camera"]
    camera = cam.Camera(**{k: tuple(v) if isinstance(v, list) else v for k, v in lens.items()})
    first = next(k for k in range(len(table)) if str(table.iloc[k, 0]) == "0")
    values = table.iloc[first : first + 5, 1:].astype(float).to_numpy().reshape(5, 5, 3)
    pixels = np.nanmedian(values[:, 2, :2], axis=0)[None]
    xy = cam.pixels_to_pool(camera, pixels, config["robot"]["keypoint_depth_m"])[0]
    assert np.allclose(xy, start[:2], atol=0.012)
    assert optics.KEYPOINT_NAMES[2] == "core_center"
