"""The tank `tow_tank`: its null is the published model, and its files and truths are usable."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from candidate_causes import LEFT_RIGHT_ASYMMETRIC_CAUSES, MEASUREMENT, PHYSICS
from click.testing import CliRunner
from scipy.optimize import fsolve
from study_files import assert_same_files

from bluekoi.cli import main
from validation.generators.tow_tank import filming, generate, plan, strength, studies
from validation.generators.tow_tank.ideal import SimulatedMotion
from validation.generators.tow_tank.motion import (
    HiddenLaw,
    derivative,
    simulate_motion,
    state_at_rest,
    straight_growth_rate,
)
from validation.generators.tow_tank.optics import draw_camera, true_statement
from validation.generators.tow_tank.robots import ParallelTrials, Robot, draw_robot

PAPER_ROBOT = Robot(mass=0.68, inertia=0.0095, body_length=0.331, head_length=0.12, span=0.069,
              hinge_to_com=0.04, tail_length=0.066, depth=0.04, C_T=4.5e-3, C_D0=0.5, C_Da=4.0,
              C_La=3.14, C_Ma=0.1, C_Md=0.104)  # fmt: skip


def still_water_trials(angles_deg, hertz=5.82, head=0.12) -> ParallelTrials:
    """Trials in still water, without errors."""
    n = len(angles_deg)
    zero, none = np.zeros(n), np.zeros((1, n))
    return ParallelTrials(power=zero + 100, head_angle=np.deg2rad(angles_deg), servo_error=zero,
                 flap=zero + hertz, head=zero + head, order=zero, start=zero + 1.3 + 0.8j,
                 heading=zero + 0.4, flow=none + 0j, rates=none, phases=none, jitter=none,
                 flow_bias=zero + 0j)  # fmt: skip


def law_of(cause: str, name: str, size: float, **shape: float) -> HiddenLaw:
    form = next(f for f in plan.CATALOGUE if (f.cause, f.name) == (cause, name))
    return HiddenLaw(form, size, {k: v[0] for k, v in form.ranges.items()} | shape)


def steady_turn(robot: Robot, phi: float, hertz: float) -> tuple[float, float]:
    """Speed and radius from the published equations in the frame of the flow, arg v = 0."""
    area, arm = 0.12 * robot.span, robot.arm(0.12)

    def rest_of(unknown):
        V, r, a = unknown
        q = 500 * area * V**2
        flow = q * (1j * robot.C_La * np.sin(2 * a)
                    - robot.C_D0 - robot.C_Da * (1 - np.cos(2 * a)))  # fmt: skip
        thrust = robot.C_T * 500 * area * hertz**2 * np.exp(1j * (a + phi))
        force = thrust + flow - 1j * robot.mass * V * r
        M = q * robot.C_Ma * np.sin(2 * a) - robot.C_Md * r * abs(r)
        moment = M + (flow * np.conj(1j * np.exp(1j * a))).real * arm
        return force.real, force.imag, moment

    V, r, _ = fsolve(rest_of, [0.4, -np.sign(phi) * 0.6, -0.3 * phi], xtol=1e-12)
    return V, abs(V / r)


@pytest.mark.parametrize("hertz", [2.37, 5.82])
def test_steady_turns_of_a_null_are_those_of_the_published_equations(hertz):
    angles = [30.0, -45.0, 45.0]
    end = simulate_motion(
        still_water_trials(angles, hertz), PAPER_ROBOT, [], np.arange(0, 20, 1 / 30)
    )[-1]
    for k, angle in enumerate(angles):
        V, radius = steady_turn(PAPER_ROBOT, np.deg2rad(angle), hertz)
        speed = np.hypot(end[3, k], end[4, k])
        assert speed == pytest.approx(V, rel=1e-4)
        assert speed / abs(end[5, k]) == pytest.approx(radius, rel=1e-4)
        assert end[5, k] * angle < 0  # positive phi turns clockwise


def test_straight_speed_and_instability_are_those_of_the_paper():
    one = still_water_trials([0.0])
    end = simulate_motion(one, PAPER_ROBOT, [], np.arange(0, 8, 1 / 60))[-1]
    assert np.hypot(end[3, 0], end[4, 0]) == pytest.approx(0.552, abs=1e-3)
    assert straight_growth_rate(PAPER_ROBOT, [], one) == pytest.approx(3.6, abs=0.1)


def test_a_robot_without_thrust_stays_at_rest():
    out = simulate_motion(
        still_water_trials([30.0, 0.0], hertz=0.0), PAPER_ROBOT, [], np.arange(0, 3, 1 / 60)
    )
    np.testing.assert_allclose(out[-1], out[0], atol=1e-12)


def test_integration_is_of_fourth_order():
    state = state_at_rest(still_water_trials([30.0]))
    state[3:6] = np.array([0.25, 0.25, -0.6])[:, None]

    def end(step):
        times = np.arange(0, 1 + step / 2, step)
        return simulate_motion(still_water_trials([30.0]), PAPER_ROBOT, [], times, state)[-1, :6, 0]

    fine = end(1 / 640)
    ratio = np.linalg.norm(end(1 / 80) - fine) / np.linalg.norm(end(1 / 160) - fine)
    assert 13 < ratio < 20


@pytest.mark.parametrize("name", ["strip", "ellipsoid"])
def test_added_masses_keep_the_energy_of_an_ideal_fluid(name):
    """Kirchhoff: without forces, 1/2 nu' (M + M_A) nu stays."""
    ideal = replace(PAPER_ROBOT, C_T=0, C_D0=0, C_Da=0, C_La=0, C_Ma=0, C_Md=0)
    mass = law_of("added_mass", name, 0.8)
    state = state_at_rest(still_water_trials([0.0]))
    state[3:6, 0] = 0.4, 0.1, 0.7
    out = simulate_motion(
        still_water_trials([0.0]), ideal, [mass], np.arange(0, 4, 1 / 120), state
    )[:, :, 0]
    mx, my, mr, inr, _ = mass(SimpleNamespace(robot=ideal))
    v = (out[:, 3] + 1j * out[:, 4]) * np.exp(-1j * out[:, 2])
    u, w, r = v.real, v.imag, out[:, 5]
    energy = (ideal.mass + mx) * u**2 + (ideal.mass + my) * w**2 + 2 * mr * w * r
    energy = energy + (ideal.inertia + inr) * r**2
    np.testing.assert_allclose(energy, energy[0], rtol=1e-6)


def test_blades_take_energy_from_a_robot_without_thrust():
    for cause in ("tail_fin_lift", "crossflow_drag", "linear_yaw_damping", "viscous_drag"):
        for form in (f for f in plan.CATALOGUE if f.cause == cause):
            state = state_at_rest(still_water_trials([0.0]))
            state[3:6, 0] = 0.3 * np.cos(0.9), 0.3 * np.sin(0.9), 0.5
            hidden = law_of(cause, form.name, np.sqrt(form.low * form.high))
            inert = replace(PAPER_ROBOT, C_D0=0, C_Da=0, C_La=0, C_Ma=0, C_Md=0, C_T=0)
            rate = derivative(0.0, state, still_water_trials([0.0]), inert, [hidden])
            power = (
                PAPER_ROBOT.mass * (state[3:5] * rate[3:5]).sum()
                + PAPER_ROBOT.inertia * 0.5 * rate[5]
            )
            assert power < 1e-12, (cause, form.name)


def test_even_laws_are_mirror_symmetric():
    times = np.arange(0, 1, 1 / 30)
    both = replace(still_water_trials([25.0, -25.0]), heading=np.zeros(2))
    for form in plan.CATALOGUE:
        asymmetric = LEFT_RIGHT_ASYMMETRIC_CAUSES | {"centre_of_mass_shift"}
        if form.cause in asymmetric or form.stage in studies.OBSERVATION_STAGES:
            continue
        size = np.sqrt(form.low * form.high)
        out = simulate_motion(both, PAPER_ROBOT, [law_of(form.cause, form.name, size)], times)
        np.testing.assert_allclose(out[:, [2, 5], 0], -out[:, [2, 5], 1], atol=1e-9)
        assert np.abs(out[-1, 5, 0]) > 1e-3


def test_a_law_of_strength_zero_gives_the_null():
    """Laws whose strength is a time or a length of memory: the limit."""
    times = np.concatenate([np.arange(20) / 1000, np.arange(0.02, 0.5, 1 / 30)])
    two = still_water_trials([30.0, -30.0], head=0.16)
    null = simulate_motion(two, PAPER_ROBOT, [], times)
    for form in plan.CATALOGUE:
        if form.stage in studies.OBSERVATION_STAGES or form.cause == "lift_lag":
            continue
        size = 1e-9 if form.unit == "s" else 0.0
        hidden = law_of(form.cause, form.name, size, **({"length": 2.6} if "length" in form.ranges
                                                     else {}))  # fmt: skip
        out = simulate_motion(two, PAPER_ROBOT, [hidden], times)
        np.testing.assert_allclose(out[:, :6], null[:, :6], atol=1e-3 if size else 1e-12)


def test_every_cause_of_the_contract_has_three_forms_and_no_other_is_named():
    forms = {}
    for form in plan.CATALOGUE:
        forms.setdefault(form.cause, set()).add(form.name)
    assert set(forms) - {plan.UNLISTED_NAME} == PHYSICS | MEASUREMENT
    assert all(len(names) >= 3 for names in forms.values())
    assert all(f.variable for f in plan.CATALOGUE if f.cause == plan.UNLISTED_NAME)


def test_shares_of_kinds_and_fins_hold_in_each_twenty():
    kinds = [plan.study_kind(3, i) for i in range(40)]
    names = [k.name for k in kinds]
    assert {n: names.count(n) / 2 for n in plan.KIND_COUNTS} == dict(plan.KIND_COUNTS)
    assert sum(k.fin for k in kinds) == 20
    assert sum(k.few for k in kinds) == 8


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_the_way_back_through_lens_and_surface_is_exact(seed):
    rng = np.random.default_rng(seed)
    camera = draw_camera(rng, (3.0, 1.8, 0.4))
    at = rng.uniform(0.1, 2.9, 50) + 1j * rng.uniform(0.1, 1.7, 50)
    back = true_statement(camera, 0.05).back(camera.see(at, np.full(50, 0.05)))
    assert np.abs(back - at).max() < 1e-6
    dry = replace(camera, index=1.0)
    flat = np.column_stack([at.real, at.imag, np.full(50, -0.05)])
    np.testing.assert_allclose(dry.see(at, np.full(50, 0.05)), dry.lens(flat), atol=1e-6)


def test_the_lenses_are_those_of_opencv():
    points = np.random.default_rng(0).uniform([0.2, 0.2, 0], [2.8, 1.6, 0.01], (20, 3))
    seen = set()
    for seed in range(12):
        camera = draw_camera(np.random.default_rng(seed), (3.0, 1.8, 0.4))
        turn, shift = cv2.Rodrigues(camera.rotation)[0], -camera.rotation @ camera.place
        project = cv2.fisheye.projectPoints if camera.fisheye else cv2.projectPoints
        args = (points[:, None], turn, shift[:, None], camera.matrix, camera.distortion)
        np.testing.assert_allclose(camera.lens(points), project(*args)[0].reshape(-1, 2), atol=1e-6)
        seen.add(camera.fisheye)
    assert seen == {True, False}


def test_sigma_grows_with_the_strength_and_knows_the_error_of_the_servo():
    rng = np.random.default_rng(8)
    setup = studies._draw_setup(rng, plan.StudyKind("single", fin=False, few=True))
    drag, offset = (
        law_of("viscous_drag", "linear", 0.004),
        law_of("head_angle_offset", "constant", 0.5),
    )
    motion = strength.simulate_from_starts(setup, [], rng, placed=False)
    found = []
    for size in (1.0, 2.0):
        laws = [replace(h, strength=size * h.strength) for h in (drag, offset)]
        full = replace(motion, laws=laws)
        found.append(
            strength.detectability_sigmas(full, strength.detector_noise(setup), [[h] for h in laws])
        )
    np.testing.assert_allclose(found[1] / found[0], 2.0, rtol=0.15)
    prior = np.deg2rad(0.5) / 5e-3
    assert 0 < found[0][1] <= 1.02 * prior * np.sqrt(9)


def test_a_fault_of_strength_zero_shows_the_null():
    rng = np.random.default_rng(6)
    setup = studies._draw_setup(rng, plan.StudyKind("null", fin=False, few=True))
    states = simulate_motion(setup.lanes, setup.robot, [], np.arange(60) / 30)
    motion = SimulatedMotion(
        setup.lanes, setup.robot, [], np.arange(60) / 30, states, np.full(9, 60)
    )
    turns = filming.shaft_turns(motion, np.zeros(9), 0.05, 2.0)

    def seen(fault):
        at = filming.labelled_points(motion, 0, turns, fault, setup.film)
        said = filming.stated_setup(setup.film, setup.robot, fault)
        px = filming.keypoint_pixels(setup.film.camera, at, motion, 0, fault)
        return px.ravel(), said.pool, said.matrix.ravel(), said.distortion

    for form in plan.CATALOGUE:
        if form.stage in studies.OBSERVATION_STAGES and form.stage != "depth":
            for null, other in zip(
                seen(None), seen(law_of(form.cause, form.name, 0.0)), strict=True
            ):
                np.testing.assert_allclose(other, null, rtol=1e-12, atol=1e-9)


@pytest.fixture(scope="module")
def generated_studies(tmp_path_factory):
    """A null, a study with a hidden drag and one with a fault of the camera; 9 trials."""
    folder = tmp_path_factory.mktemp("tank")
    drag = next(f for f in plan.CATALOGUE if f.cause == "viscous_drag")
    lens = next(f for f in plan.CATALOGUE if f.cause == "camera_shift")
    return folder, [generate(883, i, folder, forms=f) for i, f in enumerate(([], [drag], [lens]))]


def test_files_are_accepted_by_the_tool(generated_studies):
    folder, truths = generated_studies
    for truth in truths:
        done = CliRunner().invoke(main, ["check", str(folder / "studies" / truth["study"])])
        assert done.exit_code == 0, done.output
        assert "no error found in the files" in done.output


def test_truths_have_the_keys_of_the_scores_and_sigma_in_range(generated_studies):
    folder, truths = generated_studies
    for truth, hidden in zip(truths, ([], ["viscous_drag"], ["camera_shift"]), strict=True):
        path = folder / "truth" / f"{truth['study']}.json"
        assert json.loads(path.read_text()) == json.loads(json.dumps(truth))
        names = [c["name"] for c in truth["causes"]]
        assert names == (["tail_fin_lift"] if truth["fin"] else []) + hidden
        assert all(10 <= c["sigma"] <= 60 for c in truth["causes"] if c["name"] in hidden)
        assert {"group", "trials", "unlisted", "generator"} <= set(truth)
        trials = (folder / "studies" / truth["study"] / "trials.csv").read_text().splitlines()
        assert len(trials) == truth["trials"] + 1


def test_a_series_is_reproduced(generated_studies, tmp_path):
    folder, truths = generated_studies
    generate(883, 0, tmp_path, forms=[])
    study = f"studies/{truths[0]['study']}"
    assert_same_files(tmp_path / study, folder / study)


def test_the_robot_stays_in_the_pool_from_rest():
    rng = np.random.default_rng(4)
    setup = studies._draw_setup(rng, plan.StudyKind("null", fin=True, few=True))
    motion = strength.simulate_from_starts(setup, setup.fin, rng, placed=False)
    length, width, _ = setup.pool
    for k, n in enumerate(motion.frames):
        x, y = motion.states[:n, 0, k], motion.states[:n, 1, k]
        assert min(x.min(), y.min(), length - x.max(), width - y.max()) >= 0.24
        assert 2.5 <= n / setup.fps <= 10
        assert np.all(motion.states[0, 3:6, k] == 0)


def test_fins_make_straight_swimming_stable():
    for seed in range(3):
        rng = np.random.default_rng(seed)
        robot = draw_robot(rng, fin=True)
        fin = plan.draw_fin(rng, robot, still_water_trials([0.0], head=robot.head_length))
        assert straight_growth_rate(robot, [fin], still_water_trials([0.0])) < -0.08
        assert straight_growth_rate(robot, [], still_water_trials([0.0])) > 1
