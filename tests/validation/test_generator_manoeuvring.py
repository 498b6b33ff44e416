"""The manoeuvring tank: dynamics, camera, detector, composition, files."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from validation.generators.manoeuvring import (
    camera,
    detector,
    dynamics,
    effects,
    measurement,
    noise,
    studies,
)

ONE_TRIAL = np.ones(1)


def drive_in_still_water(phi=0.0, flap=5.0, head=0.12, n=1):
    one = np.ones(n)
    return dynamics.TrialInputs(
        phi * one,
        flap * one,
        head * one,
        0 * one,
        np.zeros((5, 0, n)),
        np.zeros((2, n)),
        np.zeros((2, n)),
    )


@pytest.fixture(scope="module")
def robot():
    return studies.draw_robot(np.random.default_rng(1), ())


@pytest.fixture(scope="module")
def tank():
    rng = np.random.default_rng(3)
    tank = studies.draw_tank(rng, studies.StudySlot("clear", True, 9, ("viscous_drag",)))
    drag, _ = effects.draw_effect("viscous_drag", rng)
    fin = studies.draw_fin(rng, tank.robot)
    tank, path = studies.simulate_in_pool(tank, [drag, fin], rng)
    return tank, path, drag, fin


def test_terminal_speed_of_the_paper(robot):
    path = dynamics.simulate(
        np.zeros((3, 1)), robot, drive_in_still_water(), [], fps=50, frames=600
    )
    C_T, _, C_D0 = robot.coefficients[:3]
    assert path.S[-1, 3, 0] == pytest.approx(5.0 * np.sqrt(C_T / C_D0), rel=1e-3)
    np.testing.assert_allclose(path.S[:, 1:3], 0, atol=1e-9)


def test_agrees_with_equations_about_the_centre_of_mass(robot):
    """Eq. (8) in world axes about C, from a general state, against the equations about O."""
    drive, psi, phi, r = drive_in_still_water(0.4), 0.7, 0.4, 0.9
    l, A = robot.arm(0.12), 0.12 * robot.span
    vc = 0.35 * np.exp(1j * 0.55)
    vo = (vc + 1j * r * l * np.exp(1j * psi)) * np.exp(-1j * psi)
    S = np.array([[l * np.cos(psi)], [l * np.sin(psi)], [psi], [vo.real], [vo.imag], [r], [0], [0]])
    d = dynamics.rates(ONE_TRIAL, S, robot, drive, [])[:, 0]
    a_O = ((d[3] + 1j * d[4]) + 1j * r * vo) * np.exp(1j * psi)
    a_C = a_O - (1j * d[5] - r**2) * l * np.exp(1j * psi)
    C_T, C_La, C_D0, C_Da, C_Ma, C_Md = robot.coefficients
    alpha, q, hat = psi - 0.55, 500 * A * abs(vc) ** 2, vc / abs(vc)
    LD = q * (C_La * np.sin(2 * alpha) * 1j - C_D0 - C_Da * (1 - np.cos(2 * alpha))) * hat
    T = C_T * 500 * A * 25 * np.exp(1j * (psi + phi))
    M = q * C_Ma * np.sin(2 * alpha) - C_Md * r * r
    assert robot.mass * a_C == pytest.approx(LD + T, rel=1e-9)
    N = (LD * np.conj(1j * np.exp(1j * psi))).real
    assert robot.yaw_inertia * d[5] == pytest.approx(M + N * l, rel=1e-9)


def test_positive_head_angle_turns_clockwise(robot):
    path = dynamics.simulate(
        np.zeros((3, 1)), robot, drive_in_still_water(0.5), [], fps=50, frames=200
    )
    assert path.S[-1, 5, 0] < -0.1


def test_runge_kutta_is_of_fourth_order_at_least(robot):
    S, drive = (
        np.array([[0, 0, 0, 0.4, 0.05, 0.5, 0, 0]]).T.astype(float),
        drive_in_still_water(0.5),
    )

    def end(steps):
        state = S
        for k in range(steps):
            t = k / steps * ONE_TRIAL
            state = dynamics.rk4_step(t, state, 1 / steps, robot, drive, effects=[])
        return state

    fine = end(320)
    ratio = abs(end(20) - fine).max() / abs(end(40) - fine).max()
    assert ratio > 11  # 16 for the fourth order, more where the leading term is small


@pytest.mark.parametrize("name", [*effects.CAUSES, "unlisted"])
def test_every_form_vanishes_at_zero_strength_and_acts_above(name, robot):
    cause = effects.CAUSES.get(name, effects.UNLISTED_CAUSE)
    seen = set()
    drive = drive_in_still_water(0.5, head=0.17)
    S = np.array([[0.8, 0.6, 0.9, 0.35, 0.25, 0.5, 0.1, 0.1]]).T
    drive = replace(drive, wake=np.array([[0.3], [0.1]]))
    for seed in range(60):
        e, (low, high) = effects.draw_effect(name, np.random.default_rng(seed))
        assert low < abs(e.strength) < high
        if e.form in seen or e.hook == "depth":
            continue
        seen.add(e.form)
        t = 0.15 * ONE_TRIAL
        base = dynamics.rates(t, S, robot, drive, [])[:6]
        np.testing.assert_allclose(
            dynamics.rates(t, S, robot, drive, [e.scaled(0.0)])[:6], base, atol=1e-9
        )
        assert abs(dynamics.rates(t, S, robot, drive, [e])[:6] - base).max() > 1e-9
    assert len(seen) in (0, len(cause.forms))
    assert len(cause.forms) >= 2


@pytest.mark.parametrize(
    "name", ["viscous_drag", "wave_drag", "crossflow_drag", "coulomb_friction"]
)
def test_drag_takes_power(name, robot):
    rng = np.random.default_rng(0)
    for _ in range(20):
        e, _ = effects.draw_effect(name, rng)
        u, v, r = rng.normal(0, 0.3, 3) * ONE_TRIAL[0]
        z = 0 * ONE_TRIAL
        flow = dynamics.Flow(
            robot,
            0.12 * ONE_TRIAL,
            ONE_TRIAL,
            z,
            z,
            z,
            r * ONE_TRIAL,
            ONE_TRIAL,
            0.3 * ONE_TRIAL,
            z,
            u,
            v,
        )
        flow.speed = np.hypot(u, v) * ONE_TRIAL
        X, Y, N = e(flow)
        if e.form != "modulus":
            assert np.all(X * u + Y * v + N * r <= 1e-12)


@pytest.mark.parametrize("model", ["pinhole", "fisheye", "homography"])
def test_locate_inverts_project(model):
    rng = np.random.default_rng(2)
    cam = camera.draw_camera(rng, model, (2.1, 3.0))
    xy = rng.uniform(0.1, 1, (50, 2)) * [2.5, 1.5]
    px = camera.project(cam, xy, 0.06)
    np.testing.assert_allclose(camera.pixels_to_pool(cam, px, 0.06), xy, atol=1e-6)
    edge = camera.project_in_air(cam, camera.pool_corners(2.6, 1.6, 0.03))
    assert (edge > 0).all()
    assert (edge < [1920, 1080]).all()


def test_refraction_lifts_the_keypoint_by_the_apparent_depth():
    cam = replace(
        camera.draw_camera(np.random.default_rng(0), "homography", (2.1, 3.0)), tilt=np.zeros(3)
    )
    xy = cam.centre[None, :2] + np.array([0.05, 0.0])
    s = camera.surface_crossing(cam, xy, np.array([0.1]))[0, 0] - cam.centre[0]
    H = cam.centre[2]
    assert s == pytest.approx(0.05 * H / (H + 0.1 / 1.333), rel=1e-4)


def test_pink_noise_has_unit_variance():
    z = noise.pink_noise(np.random.default_rng(0), 4000, 1 / 30, (20,))
    assert z.var() == pytest.approx(1, rel=0.1)


def test_composition_of_forty():
    slots = [studies.study_slot(5, i) for i in range(40, 80)]
    for group, count in studies.GROUP_COUNTS.items():
        assert sum(s.group == group for s in slots) == count
        assert sum(s.group == group and s.fin for s in slots) == count // 2
    assert sum(s.trials == 9 for s in slots) == 10
    dealt = [c for k in range(800) for c in studies.study_slot(k // 40, k % 40).causes]
    counts = {c: dealt.count(c) for c in (*effects.CAUSES, *measurement.FORMS)}
    del counts["tail_fin_lift"]
    assert min(counts.values()) >= 8


def test_log_likelihood_gain_is_half_sigma_squared(tank, monkeypatch):
    """Brute force: an extended Kalman filter without noise, with and without the drag."""
    monkeypatch.setattr(detector, "_water_moments", lambda *_: (1e-3, 0.9))
    tank, _, drag, fin = tank
    calm = np.zeros((5, 1, tank.trials))
    tank = replace(tank, drive=replace(tank.drive, vortices=calm))
    drag = drag.scaled(drag.strength * 0.2)
    tank, path = studies.simulate_in_pool(tank, [drag, fin], np.random.default_rng(8))
    raw = detector.detectability(tank, path, [drag, fin])[1][0]
    nb = max(2, round(0.1 * tank.fps))
    y = np.stack(path.core(tank.robot, tank.drive.head), axis=1)[
        : (len(path.t) - 1) // nb * nb : nb
    ]
    gain = extended_kalman_filter(tank, path, [drag, fin], y) - extended_kalman_filter(
        tank, path, [fin], y
    )
    assert gain == pytest.approx(raw**2 / 2, rel=0.06)


def extended_kalman_filter(tank, path, effs, y):
    b = detector.linearise(tank, path, [])
    a, var, R, prior = detector.noise_model(tank, b)
    n, nb = tank.trials, max(2, round(0.1 * tank.fps))
    x = np.zeros((17, n))
    x[:6] = path.S[0, :6]
    P = np.tile(np.diag(np.r_[prior, var]), (n, 1, 1))
    drive = replace(tank.drive, vortices=np.zeros((5, 0, n)))
    arm, gain = tank.robot.arm(tank.drive.head), 0.0
    for k in range(len(y)):
        H = np.zeros((n, 3, 17))
        H[:, range(3), range(3)] = 1
        H[:, 0, 2], H[:, 1, 2] = arm * np.sin(x[2]), -arm * np.cos(x[2])
        for i in range(3):
            H[:, i, 8 + 3 * i : 11 + 3 * i] = 1
        noise_sum = x[8:].reshape(3, 3, n).sum(1)
        guess = np.stack([x[0] - arm * np.cos(x[2]), x[1] - arm * np.sin(x[2]), x[2]]) + noise_sum
        nu, S = (y[k] - guess).T, H @ P @ H.transpose(0, 2, 1) + np.diag(R)
        ll = -0.5 * (np.einsum("ni,ni->n", nu, np.linalg.solve(S, nu[..., None])[..., 0]))
        live = np.array([k * nb < f - nb for f in tank.frames])
        gain += (ll - 0.5 * np.linalg.slogdet(S)[1])[live].sum()
        G = np.linalg.solve(S, H @ P).transpose(0, 2, 1)
        x = x + np.einsum("nij,nj->in", G, nu)
        P = P - G @ H @ P
        wide = np.repeat(x[:8, None], 9, axis=1)
        wide[6:] = 0
        wide[range(6), range(1, 7)] += 1e-5
        gust = np.repeat(x[6:8, None], 9, axis=1)
        gust[range(2), range(7, 9)] += 1e-5
        big = replace(drive.take(np.tile(np.arange(n), 9)), gust=gust.reshape(2, -1))
        t = np.full(9 * n, k * nb / tank.fps)
        end = detector.advance_block(
            wide.reshape(8, -1), t, nb / tank.fps, tank.robot, drive=big, effects=effs
        )
        end = end[:6].reshape(6, 9, n)
        A = np.zeros((n, 17, 17))
        A[:, :6, :8] = ((end[:, 1:] - end[:, :1]) / 1e-5).transpose(2, 0, 1)
        A[:, range(6, 17), range(6, 17)] = a
        x = np.concatenate([end[:, 0], a[:, None] * x[6:]])
        P = A @ P @ A.transpose(0, 2, 1) + np.diag(np.r_[np.full(6, 1e-14), var * (1 - a * a)])
    return gain


@pytest.fixture(scope="module")
def written_study(tmp_path_factory):
    slots = [studies.study_slot(2, i) for i in range(40)]
    index = next(i for i, s in enumerate(slots) if s.group == "null" and s.trials == 9)
    folders = [tmp_path_factory.mktemp(c) for c in "ab"]
    return [(f, studies.generate(2, index, f)) for f in folders]


def test_generation_is_deterministic(written_study):
    (a, reported), (b, _) = written_study
    files = sorted(p.relative_to(a) for p in a.rglob("*") if p.is_file())
    assert files == sorted(p.relative_to(b) for p in b.rglob("*") if p.is_file())
    assert all((a / f).read_bytes() == (b / f).read_bytes() for f in files)
    assert studies.generate(2, reported["index"], a) == reported


def test_truth_and_study_agree(written_study):
    folder, reported = written_study[0]
    name = reported["study"]
    assert json.loads((folder / "truth" / f"{name}.json").read_text()) == reported
    assert reported["verdict"] == ("physics" if reported["fin"] else "none")
    assert [c["name"] for c in reported["causes"]] == ["tail_fin_lift"] * reported["fin"]
    study = folder / "studies" / name
    content = yaml.safe_load((study / "study.yaml").read_text())
    assert content["robot"]["mass_kg"] == reported["robot"]["mass"]
    trials = pd.read_csv(study / "trials.csv")
    assert len(trials) == reported["trials"]
    assert all((study / s).exists() for s in trials.source)
    assert not list(study.rglob("*truth*"))


def test_keypoints_lead_back_to_the_path(tank):
    """A lab's reading of noise-free pixels gives the simulated core centre and head direction."""
    from validation.generators.manoeuvring import writing

    tank, path, drag, fin = tank
    quiet = replace(tank, noise=replace(tank.noise, recoil_deg=0.0, recoil_m=0.0))
    clock = writing.shaft_phases(quiet, [drag, fin], path.t[-1])
    px = writing.true_pixels(quiet, path, [drag, fin], 1, clock)
    z = measurement.pixels_to_stated_pool(tank.lab, px.reshape(-1, 2)).reshape(-1, 5, 2)
    x, y, psi = (a[: len(px), 1] for a in path.core(tank.robot, tank.drive.head))
    np.testing.assert_allclose(z[:, 2], np.column_stack([x, y]), atol=2e-3)
    d = z[:, 0] - z[:, 1]
    assert abs(np.angle(np.exp(1j * (np.arctan2(d[:, 1], d[:, 0]) - psi)))).max() < 0.01
