"""The tank `potential_flow`: its null is the published model, its files and truths are usable."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from candidate_causes import LEFT_RIGHT_ASYMMETRIC_CAUSES, MEASUREMENT, PHYSICS
from click.testing import CliRunner
from scipy.spatial.transform import Rotation
from study_files import assert_same_files

from bluekoi.cli import main
from validation.generators.potential_flow import fins, generate, plan, resistance
from validation.generators.potential_flow.catalogue import CATALOGUE, UNLISTED_NAME
from validation.generators.potential_flow.craft import Robot, spheroid_added_mass
from validation.generators.potential_flow.form import OPTICAL_STAGES, HiddenForm, draw_hidden
from validation.generators.potential_flow.impulse import simulate_motion
from validation.generators.potential_flow.lanes import FLAP_ERROR, SERVO_ERROR
from validation.generators.potential_flow.lens import draw_camera, pool_corners, with_fitted_pose
from validation.generators.potential_flow.stability import (
    draw_fin,
    still_water_trials,
    straight_growth_rate,
)
from validation.generators.potential_flow.tracker import correlated_errors, draw_tracker

TABLE_1_COEFFICIENTS = {
    "C_T": 4.5e-3,
    "C_D0": 0.5,
    "C_Da": 4.0,
    "C_La": 3.14,
    "C_Ma": 0.1,
    "C_Md": 0.104,
}
PAPER_ROBOT = Robot(0.68, 0.0095, 0.331, 0.12, 0.069, 0.04, 0.066, 0.04, TABLE_1_COEFFICIENTS)
MOTION_FORMS = [f for f in CATALOGUE if f.stage not in OPTICAL_STAGES]


def hidden_form(form) -> HiddenForm:
    return draw_hidden(np.random.default_rng(7), form)


def simulated_turn(laws, angles, hertz=5.82, seconds=0.8, step=1 / 120):
    world, lanes = still_water_trials(PAPER_ROBOT, laws, np.full(len(angles), hertz))
    lanes = replace(lanes, command=np.deg2rad(angles))
    return world, lanes, simulate_motion(world, lanes, seconds, step)


def test_steady_turn_satisfies_the_published_equations():
    motion = simulated_turn([], [30.0], seconds=10.0, step=1 / 60)[2]
    last = slice(-60, None)
    V, r = np.abs(motion.speed[last, 0]).mean(), motion.yaw_rate[last, 0].mean()
    a = motion.attack[last, 0].mean()
    q = 500 * 0.12 * 0.069 * V**2
    force = q * (1j * 3.14 * np.sin(2 * a) - 0.5 - 4 * (1 - np.cos(2 * a)))
    thrust = 4.5e-3 * 500 * 0.12 * 0.069 * 5.82**2 * np.exp(1j * (a + np.pi / 6))
    assert force + thrust == pytest.approx(1j * 0.68 * V * r, abs=2e-3)
    side = (force * np.exp(-1j * a)).imag
    arm = 0.12 + 0.04 - 0.331 / 4
    moment = q * 0.1 * np.sin(2 * a) + side * arm - 0.104 * r * abs(r)
    assert moment == pytest.approx(0, abs=1e-3)
    assert r < 0  # a positive head angle turns clockwise


def test_straight_speed_and_instability_are_those_of_the_paper():
    _, _, motion = simulated_turn([], [0.0], seconds=10.0, step=1 / 60)
    assert np.abs(motion.speed[-60:, 0]).mean() == pytest.approx(0.552, abs=2e-3)
    assert straight_growth_rate(PAPER_ROBOT, [], 5.82)[0] == pytest.approx(3.6, abs=0.1)


def test_integration_is_at_least_of_second_order():
    ends = [simulated_turn([], [30.0], step=1 / n)[2].place[-1, 0] for n in (100, 200, 400)]
    ratio = abs(ends[0] - ends[1]) / abs(ends[1] - ends[2])
    assert ratio > 3.3


@pytest.mark.parametrize("form", [f for f in MOTION_FORMS
                                  if f.stage != "water" and f.cause != UNLISTED_NAME],
                         ids=lambda f: f"{f.cause}-{f.name}")  # fmt: skip
def test_a_robot_without_thrust_stays_at_rest(form):
    motion = simulated_turn([hidden_form(form)], [30.0], hertz=0.0, seconds=0.1)[2]
    np.testing.assert_allclose(motion.place[-1], motion.place[0], atol=1e-12)
    np.testing.assert_allclose(motion.heading[-1], motion.heading[0], atol=1e-12)


@pytest.mark.parametrize("form", [f for f in MOTION_FORMS
                                  if f.cause not in LEFT_RIGHT_ASYMMETRIC_CAUSES],
                         ids=lambda f: f"{f.cause}-{f.name}")  # fmt: skip
def test_even_laws_are_mirror_symmetric(form):
    motion = simulated_turn([hidden_form(form)], [25.0, -25.0], seconds=0.3)[2]
    np.testing.assert_allclose(motion.heading[:, 0], -motion.heading[:, 1], atol=1e-9)
    np.testing.assert_allclose(motion.place[:, 0], np.conj(motion.place[:, 1]), atol=1e-9)
    assert abs(motion.heading[-1, 0]) > 1e-3


def test_a_coasting_spheroid_keeps_its_energy():
    """Kirchhoff: without forces U' (m + A) U + (I + J) r^2 stays."""
    ideal = replace(PAPER_ROBOT, coefficients=dict.fromkeys(PAPER_ROBOT.coefficients, 0.0))
    law = replace(hidden_form(next(f for f in CATALOGUE if f.name == "spheroid")), strength=0.8)
    world, lanes = still_water_trials(ideal, [law], [0.0])
    start = np.array([0, 0, 0, 0.4, 0.1, 0.7])[:, None]
    motion = simulate_motion(world, replace(lanes, start=start), 1.0)
    ax, ay, j = (0.8 * a for a in spheroid_added_mass(0.331, 0.069))
    U = motion.speed * np.exp(-1j * motion.heading)
    energy = ((0.68 + ax) * U.real**2 + (0.68 + ay) * U.imag**2
              + (0.0095 + j) * motion.yaw_rate**2)  # fmt: skip
    np.testing.assert_allclose(energy, np.full_like(energy, energy[0, 0]), rtol=1e-5)


def test_added_masses_of_a_sphere_and_of_a_needle():
    mass = 1000 * np.pi / 6 * 0.1**3
    ax, ay, j = spheroid_added_mass(0.1, 0.0999)
    assert (ax, ay) == pytest.approx((mass / 2, mass / 2), rel=5e-3)
    assert j < 1e-4 * mass * 0.1**2
    ax, ay, _ = spheroid_added_mass(1.0, 0.01)
    assert ay == pytest.approx(1000 * np.pi / 6 * 0.01**2, rel=1e-2)
    assert ax < 0.01 * ay


def random_state():
    return SimpleNamespace(
        craft=PAPER_ROBOT, phi=0.0, r=np.zeros(1), core=np.array([0.4 + 0.1j]), v=0.4 + 0.0j, V=0.4,
        u=0.4, thrust=0.5, flap=5.0,
    )  # fmt: skip


def test_forces_at_hand_computed_values():
    force, torque = fins.lighthill_fin(random_state(), 1.0, {})
    side = 1000 * np.pi * 0.069**2 / 4 * 0.4 * 0.1
    assert force == pytest.approx(-1j * side)
    assert torque == pytest.approx((0.171 + 0.066) * side)
    force, _ = fins.crossflow_strips(random_state(), 1.0, {})
    assert force == pytest.approx(-1j * 500 * 0.069 * (0.04 + 0.171 + 0.066) * 0.1**2)
    assert resistance.viscous_stokes(random_state(), 0.1, {})[0] == pytest.approx(-0.04)
    assert resistance.wave_quartic(random_state(), 1.0, {})[0] == pytest.approx(-(0.4**4))
    tilted = random_state()
    tilted.phi = 0.5
    assert resistance.thrust_line_sine(tilted, 0.01, {})[1] == pytest.approx(0.005 * np.sin(0.5))


def test_lattice_of_great_span_has_the_lift_of_a_flat_plate():
    """Two-dimensional limit: circulation pi c w."""
    circulations, _, _ = fins.lattice_circulations(0.1, 1e3)
    assert circulations.sum() == pytest.approx(np.pi * 0.1, rel=1e-3)


def test_fins_make_straight_swimming_stable():
    shapes = plan.forms_of("tail_fin_lift")
    for form in shapes:
        fin = draw_fin(np.random.default_rng(2), PAPER_ROBOT, form, 5.82)
        assert straight_growth_rate(PAPER_ROBOT, [fin], 5.82)[0] < 0


def test_every_cause_of_the_contract_has_three_forms_and_no_other_is_named():
    forms = {}
    for form in CATALOGUE:
        forms.setdefault(form.cause, set()).add(form.name)
    assert set(forms) - {UNLISTED_NAME} == PHYSICS | MEASUREMENT
    assert all(len(names) >= 3 for names in forms.values())
    assert all(f.variable and len(f.channels) == 1 for f in CATALOGUE if f.cause == UNLISTED_NAME)


def test_shares_of_kinds_and_every_cause_has_its_turn():
    kinds = [plan.study_kind(3, i) for i in range(60)]
    names = [k.name for k in kinds]
    assert {n: names.count(n) / 3 for n, _ in plan.KIND_COUNTS} == dict(plan.KIND_COUNTS)
    assert (sum(k.fin for k in kinds), sum(k.few for k in kinds)) == (30, 12)
    causes = {
        plan.cause_in_turn(3, k.name, k.number)
        for k in kinds
        if k.name in ("single", "measurement")
    }
    assert causes == PHYSICS | MEASUREMENT


def test_stated_noise_figures_hold():
    assert np.rad2deg(SERVO_ERROR) == pytest.approx(0.3)
    assert FLAP_ERROR == 0.003
    tracker = replace(draw_tracker(np.random.default_rng(1)), freedom=8.0)
    found = correlated_errors(np.random.default_rng(2), tracker, 40000, 30.0)
    np.testing.assert_allclose(found.std(axis=(0, 2)), tracker.sigma, rtol=0.05)
    a, b, _ = tracker.arma(30.0)
    expected = (1 + a * b) * (a + b) / (1 + 2 * a * b + b * b)
    z = found[:, 0, 0]
    assert np.corrcoef(z[1:], z[:-1])[0, 1] == pytest.approx(expected, abs=0.03)


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_lens_is_that_of_opencv_and_the_way_back_is_exact(seed):
    rng, pool = np.random.default_rng(seed), (3.6, 2.2, 0.4)
    camera = draw_camera(rng, pool, 0.05)
    at = rng.uniform(0.1, 3.5, 40) + 1j * rng.uniform(0.1, 2.1, 40)
    assert np.abs(camera.back(camera.see(at)) - at).max() < 1e-7
    points = np.column_stack([at.real, at.imag, np.zeros(40)])
    matrix = np.array([[camera.focal, 0, camera.centre[0]], [0, camera.focal, camera.centre[1]],
                       [0, 0, 1.0]])  # fmt: skip
    shift = -Rotation.from_rotvec(camera.pose[:3]).as_matrix() @ camera.pose[3:]
    project = cv2.fisheye.projectPoints if camera.fisheye else cv2.projectPoints
    args = (points[:, None], camera.pose[:3], shift, matrix, np.array(camera.distortion))
    np.testing.assert_allclose(camera.project(points), project(*args)[0].reshape(-1, 2), atol=1e-6)
    found = with_fitted_pose(camera, pool, camera.project(pool_corners(pool)))
    np.testing.assert_allclose(found.pose, camera.pose, atol=1e-6)


@pytest.fixture(scope="module")
def generated_studies(tmp_path_factory):
    """A null and a study with a fault of the camera, of nine trials."""
    folder = tmp_path_factory.mktemp("flow")
    index = next(i for i in range(40) if plan.study_kind(5, i).few)
    lens = next(f for f in CATALOGUE if f.cause == "keypoint_bias")
    return index, folder, generate(5, index, folder, forms=[lens])


def test_files_are_accepted_by_the_tool(generated_studies):
    _, folder, truth = generated_studies
    done = CliRunner().invoke(main, ["check", str(folder / "studies" / truth["study"])])
    assert done.exit_code == 0, done.output
    assert "no error found in the files" in done.output


def test_truth_has_the_keys_of_the_scores_and_sigma_in_range(generated_studies):
    _, folder, truth = generated_studies
    path = folder / "truth" / f"{truth['study']}.json"
    assert json.loads(path.read_text()) == json.loads(json.dumps(truth))
    assert [c["name"] for c in truth["causes"]][-1] == "keypoint_bias"
    assert 10 <= truth["causes"][-1]["sigma"] <= 60
    assert {"group", "trials", "unlisted", "generator", "fin", "coefficients"} <= set(truth)
    trials = (folder / "studies" / truth["study"] / "trials.csv").read_text().splitlines()
    assert len(trials) == truth["trials"] + 1 == 10


def test_same_seed_gives_the_same_bytes(generated_studies, tmp_path):
    index, folder, truth = generated_studies
    generate(5, index, tmp_path, forms=[f for f in CATALOGUE if f.cause == "keypoint_bias"][:1])
    assert_same_files(tmp_path, folder)
    assert truth["trials"] == 9
