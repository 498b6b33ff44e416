"""The pool `campus_pool`: motion, laws, detector, camera, plans, files and truths."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace

import cv2
import numpy as np
import pytest
from candidate_causes import MEASUREMENT, PHYSICS
from click.testing import CliRunner
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation
from study_files import assert_same_files

from bluekoi.camera import map_keypoints, pixel_to_pool_jacobian, pool_camera
from bluekoi.cli import main
from bluekoi.keypoints.deeplabcut import read_keypoints_of_trial
from bluekoi.motor import flapping_from_log
from bluekoi.pose import rigid_pose
from bluekoi.study import load_study
from validation.generators.campus_pool import choose, generate, optics, plan, robot
from validation.generators.campus_pool.decks import orders
from validation.generators.campus_pool.detector import Detector, remaining
from validation.generators.campus_pool.dynamics import evaluate
from validation.generators.campus_pool.registry import FORMS, UNLISTED, UNLISTED_FACTS
from validation.generators.campus_pool.simulate import integrate, simulate
from validation.generators.campus_pool.world import COEFFICIENTS, Pool, Robot, Scales, World
from validation.generators.campus_pool.write import frame_times

PAPER_ROBOT = Robot(mass=0.68, inertia=0.0095, body=0.331, head=0.12, span=0.069,
                    hinge_to_com=0.04, tail=0.066, depth=0.04)  # fmt: skip
PAPER_COEFFICIENTS = dict(zip(COEFFICIENTS, (4.5e-3, 0.5, 4.0, 3.14, 0.1, 0.104), strict=True))
HERTZ, SPEED, POOL = 5.82, 0.552, (5.0, 3.0)
FISHEYE_NULL, PINHOLE_NULL, FIN_AND_LOSS = 44, 53, 46
"""Studies with 9 trials of the seed 2; the nulls have a motor log."""


def still_water(*angles_deg: float, forces: bool = True) -> World:
    """The published robot in still water, without errors; without `forces` nothing acts on it."""
    one = np.ones(len(angles_deg))
    phi = np.radians(angles_deg)
    trials = robot.bare_trials(100 * one, phi, HERTZ * one, 0.12 * one, 0.3 * one)
    scales = Scales(SPEED, 0.63, 1.0, 0.104, 0.331, 0.331 / SPEED, HERTZ / 0.7)
    coef = {k: v * forces for k, v in PAPER_COEFFICIENTS.items()}
    return World(PAPER_ROBOT, PAPER_ROBOT, coef, scales, Pool(*POOL, 1.0), None, trials, {}, 30, 1)


def random_states(count: int) -> np.ndarray:
    size = np.array([0.3, 0.3, 1, 0.5, 0.5, 0.9, 0, 0])
    return np.random.default_rng(4).normal(size=(8, count, 1)) * size[:, None, None]


def published_loads(theta, v, r, phi):
    """Force and moment on the paper's robot."""
    C_T, C_D0, C_Da, C_La, C_Ma, C_Md = PAPER_COEFFICIENTS.values()
    half_area, v_hat, alpha = 500 * 0.12 * 0.069, v / np.abs(v), theta - np.angle(v)
    q, T = half_area * np.abs(v) ** 2, C_T * half_area * HERTZ**2 * np.exp(1j * (theta + phi))
    L = q * C_La * np.sin(2 * alpha) * v_hat * 1j
    D = -q * (C_D0 + C_Da * (1 - np.cos(2 * alpha))) * v_hat
    N = ((L + D) * np.conj(1j * np.exp(1j * theta))).real
    M = q * C_Ma * np.sin(2 * alpha) - C_Md * r * np.abs(r)
    return T + L + D, M + N * (0.12 + 0.04 - 0.331 / 4)


def test_rates_are_those_of_the_published_equations():
    world, state = still_water(*np.linspace(-45, 45, 7)), random_states(7)
    theta, v, r = state[2], state[3] + 1j * state[4], state[5]
    force, moment = published_loads(theta, v, r, world.trials.phi_cmd)
    found = evaluate(world, np.float64(0.0), state, [])
    np.testing.assert_array_equal(found[:3], state[3:6])
    np.testing.assert_allclose(found[3] + 1j * found[4], force / 0.68, rtol=1e-6)
    np.testing.assert_allclose(found[5], moment / 0.0095, rtol=1e-6)


def rest_of_steady_turn(unknown, phi):
    """In the frame of the flow, arg v = 0."""
    V, r, alpha = unknown
    force, moment = published_loads(alpha, V + 0j, r, phi)
    return force.real, force.imag - 0.68 * V * r, moment


def test_steady_turns_are_those_of_the_published_equations_and_clockwise_for_positive_angles():
    angles = [30.0, -45.0, 45.0]
    end = integrate(still_water(*angles), [], 20.0).state[:, :, -1]
    for k, phi in enumerate(np.radians(angles)):
        guess = [0.4, -np.sign(phi) * 0.6, -0.3 * phi]
        V, r, _ = fsolve(rest_of_steady_turn, guess, (phi,), xtol=1e-12)
        assert np.hypot(end[3, k], end[4, k]) == pytest.approx(V, rel=1e-4)
        assert end[5, k] == pytest.approx(r, rel=1e-4)
        assert end[5, k] * phi < 0


def test_straight_speed_and_instability_are_those_of_the_paper_and_fins_stabilise():
    world = still_water(0.0)
    assert integrate(world, [], 10.0).state[3, 0, -1] == pytest.approx(SPEED, abs=1e-3)
    assert robot.straight_growth(world, []) / world.scales.time == pytest.approx(3.6, abs=0.1)
    for seed in range(4):
        rng = np.random.default_rng(seed)
        drawn = robot.stub_world(rng)
        fin = next(f for f in (robot.draw_fin(rng, drawn) for _ in range(50)) if f)
        assert robot.straight_growth(drawn, []) > 0.5
        assert -0.62 < robot.straight_growth(drawn, [fin]) < -0.029


@pytest.mark.parametrize("form", FORMS["added_mass"], ids=lambda f: f.label)
def test_added_masses_keep_the_energy_of_an_ideal_fluid(form):
    law = form.draw(np.random.default_rng(1))
    world = still_water(30.0, forces=False)
    world.trials.start[3:, 0] = 0.4, 0.1, 0.7
    path = integrate(world, [law], 4.0)
    work = type("Work", (), {"rb": PAPER_ROBOT, "k": world.trials})()
    law.apply(work)
    m11, m22, m23, m33 = (float(np.squeeze(a)) for a in work.added)
    assert max(m11, m22) > 0.01 * PAPER_ROBOT.mass
    v = (path.state[3] + 1j * path.state[4]) * np.exp(-1j * (path.state[2] + path.phi))
    u, w, r = v.real, v.imag, path.state[5]
    energy = (0.68 + m11) * u**2 + (0.68 + m22) * w**2 + 2 * m23 * w * r + (0.0095 + m33) * r**2
    np.testing.assert_allclose(energy, energy[0, 0], rtol=1e-4)


@pytest.mark.parametrize("cause", ["viscous_drag", "wave_drag", "coulomb_friction",
                                   "crossflow_drag", "linear_yaw_damping"])  # fmt: skip
def test_resistance_takes_energy(cause):
    world, state = still_water(*np.zeros(8), forces=False), random_states(8)
    for form in FORMS[cause]:
        found = evaluate(world, np.float64(0.0), state, [form.draw(np.random.default_rng(2))])
        power = 0.68 * (found[3:5] * state[3:5]).sum(axis=0) + 0.0095 * found[5] * state[5]
        assert power.max() <= 1e-12, form.label
        assert power.min() < 0, form.label


@pytest.fixture(scope="module")
def session():
    """A null without a fin, with two head lengths, and its paths long enough to meet wakes."""
    world, _ = plan.build(np.random.default_rng(3), 9, False, ["thrust_area", "wake_reentry"])
    return world, simulate(world, [])


def test_every_cause_has_four_forms_and_each_shows_in_motion_or_labels(session):
    assert set(FORMS) == PHYSICS | MEASUREMENT
    assert {form.label for form in UNLISTED} == set(UNLISTED_FACTS)
    rng, ideal = np.random.default_rng(0), Detector(session[0], [], session[1])
    for name, forms in {**FORMS, "unlisted": UNLISTED}.items():
        assert len({form.label for form in forms}) >= 4, name
        for form in forms:
            column = ideal.column(form.draw(rng).with_amp(form.cap), False)
            shown = np.abs(column.rate).max() + np.abs(column.shift).max()
            assert 1e-3 < shown < np.inf, form.label


def test_sigma_is_proportional_and_knows_the_error_of_the_servo(session):
    world, path = session
    names = ("viscous_drag", "head_angle_offset")
    laws = [FORMS[name][0].draw(np.random.default_rng(1)) for name in names]
    twice = [law.with_amp(2 * law.params["amp"]) for law in laws]
    once, double = (np.array(choose.weigh(world, [], path, one)[0]) for one in (laws, twice))
    np.testing.assert_allclose(double, 2 * once, rtol=1e-3)
    assert 0 < once[1] < laws[1].params["amp"] / np.radians(0.3) * np.sqrt(9)
    present = Detector(world, laws[:1], path).column(laws[0], True).rate
    added = Detector(world, [], path).column(laws[0], False).rate
    np.testing.assert_allclose(present, added, atol=1e-9)


def test_what_a_nuisance_can_imitate_does_not_count():
    columns = np.array([[3.0, 0.0], [1.0, 0.0], [4.0, 2.0]])
    for free, prior, left in [([], 0, 9), ([1], 0, 0), ([2], 0, 9 / 5), ([1], 1, 9 / 2)]:
        found = remaining(columns @ columns.T, 0, free, np.full(3, prior))
        assert found == pytest.approx(np.sqrt(left), abs=1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_the_way_back_through_lens_and_surface_is_exact(seed):
    rng = np.random.default_rng(seed)
    camera = optics.hang(rng, *POOL)
    at = rng.uniform(0.1, 4.9, 50) + 1j * rng.uniform(0.1, 2.9, 50)
    pixels = optics.see(camera, at, 0.2, 1.333)
    assert np.all((pixels > 0) & (pixels < np.array(camera.size)))
    np.testing.assert_allclose(optics.place(camera, pixels, 0.2, 1.333), at, atol=1e-7)
    dry = optics.see_mark(camera, np.column_stack([at.real, at.imag, np.full(50, -0.2)]))
    np.testing.assert_allclose(optics.see(camera, at, 0.2, 1.0), dry, atol=1e-6)
    turn, move = np.array([0.02, -0.01, 0.03]), np.array([0.1, 0.0, 0.2])
    turned = Rotation.from_rotvec(turn).as_matrix() @ camera.turn
    moved = replace(camera, turn=turned, position=camera.position + move)
    shaken = optics.see(camera, at, 0.2, 1.333, turn=turn, move=np.tile(move, (50, 1)))
    np.testing.assert_allclose(shaken, optics.see(moved, at, 0.2, 1.333), atol=1e-6)
    corners = optics.see_mark(camera, optics.corner_points(*POOL, 0.05))
    found = optics.with_pose(optics.Stated(moved, *POOL, 1.333, 0.2, 0.05, corners=corners))
    pose = np.vstack([camera.position, camera.turn])
    np.testing.assert_allclose(np.vstack([found.position, found.turn]), pose, atol=1e-5)


def test_the_lenses_are_those_of_opencv():
    points = np.random.default_rng(0).uniform([0.2, 0.2, 0.0], [4.8, 2.8, 0.04], (20, 3))
    models = set()
    for seed in range(8):
        camera = optics.hang(np.random.default_rng(seed), *POOL)
        matrix = np.diag([*camera.focal, 1.0])
        matrix[:2, 2] = camera.centre
        project = (cv2.fisheye if camera.model == "fisheye" else cv2).projectPoints
        pose = cv2.Rodrigues(camera.turn)[0], (-camera.turn @ camera.position)[:, None]
        seen = project(points[:, None], *pose, matrix, np.array(camera.distortion))[0]
        np.testing.assert_allclose(optics.see_mark(camera, points), seen.reshape(-1, 2), atol=1e-6)
        models.add(camera.model)
    assert models == {"fisheye", "pinhole"}


@pytest.mark.parametrize("block", [0, 1])
def test_shares_of_groups_fins_and_trials_hold_in_each_sixty(block):
    plans = orders(7, block)
    many, few = plans[:40], plans[40:]
    assert Counter(p.group for p in many) == {
        "null": 6, "one": 14, "two": 12, "faint": 4, "unlisted": 4
    }  # fmt: skip
    assert Counter(p.group for p in few) == {"null": 4, "one": 16}
    for part in (many, few):
        fins = Counter(p.group for p in part if p.fin)
        assert fins == {g: n // 2 for g, n in Counter(p.group for p in part).items()}
    assert {p.trials for p in many} <= set(range(24, 31))
    assert {p.trials for p in few} == {9}
    counts = Counter(name for p in plans for name in p.names)
    assert set(counts) == (PHYSICS | MEASUREMENT) - {"tail_fin_lift"}
    assert max(counts.values()) <= 3
    wanted = {"null": 0, "one": 1, "two": 2, "faint": 1, "unlisted": 0}
    assert all(len(set(p.names)) == wanted[p.group] for p in plans)
    assert len({p.unlisted for p in plans if p.group == "unlisted"}) == 4


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folder; truth and study, as the tool reads it, by index."""
    folder = tmp_path_factory.mktemp("pool")
    truths = {i: generate(2, i, folder) for i in (FISHEYE_NULL, PINHOLE_NULL, FIN_AND_LOSS)}
    return folder, {i: (t, load_study(folder / "studies" / t["study"])) for i, t in truths.items()}


def test_files_are_accepted_by_the_tool(made):
    done = CliRunner().invoke(main, ["check", str(made[1][PINHOLE_NULL][1].root)])
    assert done.exit_code == 0, done.output
    assert "no error found in the files" in done.output


def test_truths_have_the_keys_of_the_scores_and_sigma_in_range(made):
    folder, studies = made
    for truth, study in studies.values():
        assert json.loads((folder / "truth" / f"{truth['study']}.json").read_text()) == truth
        assert {"group", "generator", "seed", "noise", "robot", "unlisted"} <= set(truth)
        assert len(study.trials) == truth["trials"] == 9
        assert truth["verdict"] == ("physics" if truth["fin"] else "none")
    assert [studies[i][0]["causes"] for i in (FISHEYE_NULL, PINHOLE_NULL)] == [[], []]
    causes = {c["name"]: c for c in studies[FIN_AND_LOSS][0]["causes"]}
    assert set(causes) == {"tail_fin_lift", "thrust_loss_with_speed"}
    for cause in causes.values():
        assert 6 <= cause["sigma"] <= 40
        assert choose.LEAST_BESIDE <= cause["sigma_beside_best_rival"] <= cause["sigma"]


def test_the_same_seed_gives_the_same_study(made, tmp_path):
    folder, studies = made
    assert generate(2, FISHEYE_NULL, tmp_path) == studies[FISHEYE_NULL][0]
    assert_same_files(tmp_path, folder)


@pytest.mark.parametrize("index", [FISHEYE_NULL, PINHOLE_NULL])
def test_the_measured_path_of_a_null_is_the_true_one_within_the_label_noise(made, index):
    """As the tool measures it from the files alone, with the signs of head angle and turn."""
    truth, study = made[1][index]
    found = choose.find(np.random.default_rng([2, index, 5801]), orders(2, 0)[index])
    true = found.path.at(frame_times(found.world, found)[1])
    camera, depth = pool_camera(study.setup), study.setup.robot.keypoint_depth_m
    gaps, sides = [], Counter()
    for i, trial in enumerate(study.trials):
        labels = read_keypoints_of_trial(study.paths(trial)[0], trial)
        read = map_keypoints(camera, labels, depth)
        gap = read.part("core_center") - true.state[:2, i, : len(read.time_s)].T
        slope = pixel_to_pool_jacobian(camera, labels.part("core_center"), depth)
        gaps.extend(np.linalg.solve(slope, gap[..., None])[..., 0])
        pose, phi = rigid_pose(read, study.setup.robot, trial.head_length_m), true.phi[i, 0]
        assert np.nanmedian(pose.values[:, 3]) == pytest.approx(phi, abs=0.01)
        assert trial.head_angle_rad == pytest.approx(phi, abs=0.02)
        early, late = np.array_split(pose.values[:, 2], 2)
        if abs(phi) > 0.25:
            assert (np.nanmedian(late) - np.nanmedian(early)) * phi < 0
            sides[phi > 0] += 1
    assert len(sides) == 2
    label = np.hypot(truth["noise"]["white_px"], truth["noise"]["correlated_px"])
    robust = 1.4826 * np.nanmedian(np.abs(gaps), axis=0)
    assert np.all((robust > 0.9 * label) & (robust < 1.2 * label))  # the tail beat adds some
    assert np.all(np.abs(np.nanmedian(gaps, axis=0)) < 0.2 * label)


def test_flapping_frequencies_are_the_true_ones(made):
    for index, (truth, study) in made[1].items():
        logs = [study.motor_path(trial) for trial in study.trials]
        stated = [trial.flap_hz for trial in study.trials]
        hertz = [flapping_from_log(log).flap_hz for log in logs] if all(logs) else stated
        assert truth["conditions"]["motor_log"] == (index != FIN_AND_LOSS)
        np.testing.assert_allclose(hertz, truth["conditions"]["flap_hz"], rtol=2e-3)
