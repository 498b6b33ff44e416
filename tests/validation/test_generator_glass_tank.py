"""The glass tank's generator: its motion, its laws, its camera, its detector and its files."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from candidate_causes import MEASUREMENT, PHYSICS
from glass_tank_cases import cause_of, forces, random_states, robot_of, trials_of
from scipy.integrate import solve_ivp
from study_files import assert_same_files

from validation.generators.glass_tank import camera, catalogue, generate, laws_unlisted
from validation.generators.glass_tank.dynamics import Setting, simulate, stability
from validation.generators.glass_tank.weather import Calm, Weather, draw_noise

ROOT = Path(__file__).resolve().parents[2]
UNLISTED = [("unlisted", form) for form in laws_unlisted.FORCES]
LISTED = [(name, form) for name in PHYSICS for form in catalogue.FAMILIES[name].forms]
FORCES = sorted(LISTED) + UNLISTED
DISSIPATIVE = {"tail_fin_lift", "crossflow_drag", "linear_yaw_damping", "viscous_drag",
               "wave_drag", "coulomb_friction", "spin_drag", "hinge_gap_drag",
               "sideslip_brake"}  # fmt: skip
IN_POOL_AXES = {"uniform_current", "pool_gyre", "tether_pull", "compass_torque"}


def published_rates(_, y, robot, coefficients, phi):
    """Equations (1) to (8) of the paper; y: x, y, head direction and their rates."""
    C_T, C_D0, C_Da, C_La, C_Ma, C_Md = coefficients
    x_dot, theta, theta_dot = y[3] + 1j * y[4], y[2], y[5]
    area, V = robot.head_length * robot.span, abs(x_dot)
    v_hat = x_dot / V if V else 0j
    alpha, q = theta - np.angle(x_dot), 0.5 * robot.density * area * V**2
    thrust = C_T * 0.5 * robot.density * area * robot.top_flap**2 * np.exp(1j * (theta + phi))
    lift = q * C_La * np.sin(2 * alpha) * v_hat * 1j
    drag = -q * (C_D0 + C_Da * (1 - np.cos(2 * alpha))) * v_hat
    moment = q * C_Ma * np.sin(2 * alpha) - C_Md * theta_dot * abs(theta_dot)
    normal = ((lift + drag) * np.conj(1j * np.exp(1j * theta))).real
    arm = robot.head_length + robot.hinge_to_com - robot.body_length / 4
    a, turn = (thrust + lift + drag) / robot.mass, (moment + normal * arm) / robot.inertia
    return [x_dot.real, x_dot.imag, theta_dot, a.real, a.imag, turn]


def test_motion_without_causes_is_that_of_the_published_equations():
    _, robot, coefficients = robot_of(1)
    angles = np.radians([-40.0, 20.0, 45.0])
    first = np.zeros((6, 3))
    first[3] = 0.01
    setting = Setting(robot, trials_of(robot, angles), [])
    found = simulate(first, 200, setting, coefficients, Calm(3)).states[200]
    for k, phi in enumerate(angles):
        start, constants = [0, 0, -phi, 0.01, 0, 0], (robot, coefficients, phi)
        exact = solve_ivp(published_rates, (0, 5), start, args=constants, rtol=1e-9, atol=1e-11)
        expected = exact.y[:, -1] + [0, 0, phi, 0, 0, 0]
        tolerance = 3e-4 * max(1, np.abs(expected).max())
        np.testing.assert_allclose(found[:, k], expected, atol=tolerance)
    assert found[5, 2] < 0  # positive angles turn clockwise


@pytest.mark.parametrize(("name", "form"), FORCES)
def test_laws_do_something_when_moving_and_nothing_at_rest(name, form):
    rng, robot, coefficients = robot_of(2)
    cause = cause_of(rng, robot, name, form)
    state, trials = random_states(rng, robot, memory=cause.memory_states)
    if not {name, form} & IN_POOL_AXES:
        still = state.copy()
        still[3:] = 0
        stopped = replace(trials, flap=0 * trials.flap)
        assert np.abs(forces(still, stopped, robot, coefficients, [cause]).rates).max() < 1e-9
    if name == "thrust_area":
        trials.head = trials.head * 1.3
    if name != "motor_spin_up":
        t = 0.02 if name == "servo_lag" else 3.0
        there = forces(state, trials, robot, coefficients, [cause], t).rates
        without = forces(state, trials, robot, coefficients, [], t).rates
        assert np.abs(there[3:6] - without[3:6]).max() > 1e-5


@pytest.mark.parametrize(("name", "form"), [c for c in FORCES if not {*c} & IN_POOL_AXES])
def test_even_laws_are_mirror_symmetric_and_odd_laws_change_sign(name, form):
    rng, robot, coefficients = robot_of(2)
    cause = cause_of(rng, robot, name, form)
    state, trials = random_states(rng, robot, memory=cause.memory_states)
    memory = 1 if form == "goman_khrabrov" else -1  # share of separated flow, or lift
    flip = np.array([1, -1, -1, 1, -1, -1, *[memory] * cause.memory_states])[:, None]
    expected = forces(state, trials, robot, coefficients, [cause]).rates * flip
    mirrored = state * flip
    mirrored[1] += robot.pool[1]
    if cause.family.parity_of(form) == "odd":
        cause.strength = -cause.strength
    there = replace(trials, phi=-trials.phi, heading=-trials.heading)
    found = forces(mirrored, there, robot, coefficients, [cause]).rates
    np.testing.assert_allclose(found, expected, atol=1e-9 * max(1, np.abs(expected).max()))


@pytest.mark.parametrize(("name", "form"), [c for c in FORCES if {*c} & DISSIPATIVE])
def test_drag_laws_take_energy(name, form):
    rng, robot, coefficients = robot_of(3)
    cause = cause_of(rng, robot, name, form)
    state, trials = random_states(rng, robot, 200)
    a, b = (forces(state, trials, robot, coefficients, causes) for causes in ([cause], []))
    power = ((a.force - b.force) * np.conj(a.velocity)).real + (a.moment - b.moment) * a.r
    assert power.max() <= 1e-12
    assert power.min() < -1e-6


@pytest.mark.parametrize("form", catalogue.FAMILIES["added_mass"].forms)
def test_added_mass_keeps_energy_unless_viscosity_reduces_the_munk_moment(form):
    rng, robot, _ = robot_of(4)
    cause = cause_of(rng, robot, "added_mass", form)
    state, trials = random_states(rng, robot, 3)
    trials.flap = 0 * trials.flap
    setting = Setting(robot, trials, [cause])
    states = simulate(state, 120, setting, [*[0.0] * 6, cause.strength], Calm(3)).states

    def energy(state):
        body = (state[3] + 1j * state[4]) * np.exp(-1j * state[2])
        added = forces(state, trials, robot, [0.0] * 6, [cause]).added
        along = (robot.mass + added.surge) * body.real**2
        across = (robot.mass + added.sway) * body.imag**2
        turning = (robot.inertia + added.yaw) * state[5] ** 2
        return 0.5 * (along + across + turning + 2 * added.coupling * body.imag * state[5])

    kept = np.allclose(energy(states[0]), energy(states[-1]), rtol=2e-4)
    assert kept == (form != "partial_munk")


def test_a_fin_stabilises():
    rng, robot, coefficients = robot_of(5)
    fin = cause_of(rng, robot, "tail_fin_lift", "abs_u", 0.75)
    with_fin = stability(robot, [*coefficients, fin.strength], [fin])
    assert with_fin < stability(robot, coefficients, [])


@pytest.mark.parametrize("name", ["battery_sag", "thrust_loss_with_speed", "viscous_drag",
                                  "wave_drag", "coulomb_friction", "motor_spin_up"])  # fmt: skip
def test_losses_slow_down(name):
    rng, robot, coefficients = robot_of(5)
    state, trials = random_states(rng, robot, 30)
    base = forces(state, trials, robot, coefficients, [], 9.0)
    cause = cause_of(rng, robot, name, catalogue.FAMILIES[name].forms[0])
    t = 0.05 if name == "motor_spin_up" else 9.0
    found = forces(state, trials, robot, coefficients, [cause], t)
    assert np.all(((found.force - base.force) * np.conj(base.axis)).real < 0)


def test_positive_trim_turns_to_port_and_suction_pulls_to_the_near_wall():
    rng, robot, coefficients = robot_of(5)
    state, trials = random_states(rng, robot, 30)
    state[0], state[1] = 0.5 * robot.pool[0], 0.06 * robot.pool[1]
    base = forces(state, trials, robot, coefficients, [])
    trim = cause_of(rng, robot, "trim_moment", "thrust")
    assert np.all(forces(state, trials, robot, coefficients, [trim]).moment > base.moment)
    wall = cause_of(rng, robot, "wall_effect", "image_suction")
    pulled = forces(state, trials, robot, coefficients, [wall])
    assert np.all((pulled.force - base.force).imag < 0)


def test_water_is_free_of_divergence_and_does_not_cross_the_walls():
    rng, robot, _ = robot_of(6)
    water = Weather(rng, robot, draw_noise(rng, robot), 50)
    x, y, step = np.full(6, 0.37 * robot.pool[0]), np.full(6, 0.41 * robot.pool[1]), 1e-5
    by_x = water.drift(9, x + step, y).real - water.drift(9, x - step, y).real
    by_y = water.drift(9, x, y + step).imag - water.drift(9, x, y - step).imag
    np.testing.assert_allclose((by_x + by_y) / (2 * step), 0, atol=1e-7)
    np.testing.assert_allclose(water.drift(9, 0 * x, y).real, 0, atol=1e-12)
    np.testing.assert_allclose(water.drift(9, x, 0 * y + robot.pool[1]).imag, 0, atol=1e-12)


def test_refraction_follows_snell_and_is_undone():
    rng = np.random.default_rng(8)
    view = camera.draw_camera(rng, (3.0, 2.0), 0.05, fisheye=False)
    x, y, depth = rng.uniform(0.1, 2.9, 50), rng.uniform(0.1, 1.9, 50), np.full(50, 0.2)
    pixels = camera.project(view, x, y, depth, 1.333)
    np.testing.assert_allclose(camera.unproject(view, *pixels, depth, 1.333), [x, y], atol=1e-7)
    across, along = camera.surface_point(view, x, y, depth, 1.333)
    in_air = np.hypot(across - view.eye[0], along - view.eye[1])
    air = np.sin(np.arctan2(in_air, view.eye[2]))
    water = np.sin(np.arctan2(np.hypot(x - across, y - along), depth))
    np.testing.assert_allclose(air, 1.333 * water, atol=1e-9)


@pytest.mark.parametrize("fisheye", [False, True])
def test_camera_is_that_of_opencv(fisheye):
    rng = np.random.default_rng(8)
    view = camera.draw_camera(rng, (3.0, 2.0), 0.05, fisheye=fisheye)
    places = np.column_stack([rng.uniform(0.1, 2.9, 50), rng.uniform(0.1, 1.9, 50), np.zeros(50)])
    turn = view.world_to_camera
    pose = cv2.Rodrigues(turn)[0], -turn @ np.array(view.eye)
    matrix = np.array([[view.fx, 0, view.cx], [0, view.fy, view.cy], [0, 0, 1]])
    project = cv2.fisheye.projectPoints if fisheye else cv2.projectPoints
    expected = project(places[:, None], *pose, matrix, np.array(view.distortion))[0][:, 0]
    np.testing.assert_allclose(np.column_stack(camera.pixel(view, *places.T)), expected, atol=1e-6)


@pytest.fixture(scope="module")
def generated_study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tank")
    return folder, generate(7, 2, folder)


def test_a_study_is_reproduced_in_another_process(generated_study, tmp_path):
    program = (
        "import sys, pathlib; from validation.generators.glass_tank import generate;"
        "generate(7, 2, pathlib.Path(sys.argv[1]))"
    )
    command = [sys.executable, "-P", "-c", program, str(tmp_path)]
    subprocess.run(command, check=True, env={**os.environ, "PYTHONPATH": str(ROOT)})
    assert_same_files(tmp_path, generated_study[0])
    assert_same_files(generated_study[0], tmp_path)


def test_files_have_the_layout_of_keypoint_studies(generated_study):
    folder, truth = generated_study
    written = folder / "studies" / truth["study"]
    content = yaml.safe_load((written / "study.yaml").read_text())
    sections = {"pool", "water", "robot", "camera"}
    assert sections <= set(content) <= sections | {"bodyparts"}
    assert set(content["pool"]) == {"length_m", "width_m", "depth_m"}
    assert set(content["robot"]) == {
        "mass_kg", "yaw_inertia_kg_m2", "body_length_m", "head_length_m", "head_span_m",
        "hinge_to_com_m", "tail_length_m", "keypoint_depth_m",
    }  # fmt: skip
    model, distortion = content["camera"]["model"], content["camera"]["distortion"]
    assert len(distortion) == (4 if model == "fisheye" else 5)
    rows = list(csv.DictReader((written / "trials.csv").open()))
    assert len({row["trial_id"] for row in rows}) == len(rows) == truth["trials"]
    assert list(rows[0])[-1] == ("motor_log" if truth["logged"] else "flap_hz")
    for row in rows:
        lines = [line.split(",") for line in (written / row["source"]).read_text().splitlines()]
        assert [cells[0] for cells in lines[:3]] == ["scorer", "bodyparts", "coords"]
        assert lines[2][1:] == ["x", "y", "likelihood"] * 5
        assert {len(cells) for cells in lines} == {16}
        assert 6 <= (len(lines) - 4) / float(row["fps"]) <= 25


def test_the_truth_has_the_keys_of_the_scores(generated_study):
    folder, truth = generated_study
    path = folder / "truth" / "glass_tank-7-002.json"
    assert json.loads(path.read_text()) == truth
    assert (truth["study"], truth["generator"]) == (path.stem, "glass_tank")
    assert set(truth) == {
        "study", "generator", "seed", "index", "group", "fin", "trials", "causes", "unlisted",
        "coefficients", "stability_per_s", "noise", "logged",
    }  # fmt: skip


def test_every_named_cause_is_hidden_about_equally_often_in_several_forms():
    assert set(catalogue.FAMILIES) == PHYSICS | MEASUREMENT
    assert all(len(family.forms) >= 2 for family in catalogue.FAMILIES.values())
    rng = np.random.default_rng(0)
    drawn = [catalogue.draw_names(rng, "single")[0] for _ in range(2400)]
    names, counts = np.unique(drawn, return_counts=True)
    assert set(names) == PHYSICS - {"tail_fin_lift"}
    assert counts.min() > 60
    assert counts.max() < 150
