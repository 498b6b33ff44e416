"""The flume's generator: its motion, its laws, its camera, its detector and its files."""

from __future__ import annotations

import json
from dataclasses import fields, replace

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import solve_ivp
from study_files import assert_same_files

from bluekoi.cli import main
from validation.generators.flume_team import detector, footage, generate, optics, plan, studies
from validation.generators.flume_team.form import MEASUREMENT, HiddenCause, Lanes
from validation.generators.flume_team.gusts import Gusts
from validation.generators.flume_team.motion import first_states, rates, simulate
from validation.generators.flume_team.robots import Coefficients, Robot
from validation.generators.flume_team.stability import growth_rate, with_fin

TABLE_I = Coefficients(C_T=4.5e-3, C_D0=0.5, C_Da=4.0, C_La=3.14, C_Ma=0.1, C_Md=0.104)
PAPER_ROBOT = Robot(TABLE_I, 0.68, 0.0095, 0.331, 0.12, 0.069, 0.04, 0.066, 0.05)
FINNED_ROBOT = with_fin(np.random.default_rng(1), PAPER_ROBOT)
POOL, DT = (6.0, 3.0), 1 / 120
MOTION_FORMS = [f for f in plan.CATALOGUE if f.kind != MEASUREMENT]


def lanes_at(*angles_deg: float, flap_hz: float = 5.0) -> Lanes:
    one = np.ones(len(angles_deg))
    luck = np.linspace(0, 1, one.size)
    return Lanes(np.radians(angles_deg), flap_hz * one, 0.12 * one, 0 * one, luck, POOL)


def swim(lanes: Lanes, seconds: float, robot: Robot = PAPER_ROBOT, hidden=(), first=None):
    first = first_states(3 + 1.5j + 0 * lanes.phi, lanes) if first is None else first
    still = np.zeros((2 * round(seconds / DT) + 1, 3, lanes.phi.size))
    return simulate(first, lanes, robot, hidden, gusts=still, dt=DT)


def random_states(count: int) -> np.ndarray:
    rng = np.random.default_rng(4)
    state = rng.normal(size=(8, count)) * np.array([0.3, 0.3, 1, 0.2, 0.2, 0.6, 0.2, 0.2])[:, None]
    return state + np.array([3.0, 1.5, 0, 0, 0, 0, 0, 0])[:, None]


def cause_of(form) -> HiddenCause:
    values = {name: 0.4 * low + 0.6 * high for name, (low, high) in form.shape.items()}
    return HiddenCause(form, form.start, values)


def cause_named(name: str) -> HiddenCause:
    return cause_of(next(f for f in plan.CATALOGUE if f.name == name))


def published_rates(_, y, phi: float, f: float) -> list[float]:
    """Equations (1) to (8) of the paper; y: x, y, head direction and their rates."""
    x_dot, theta, theta_dot = y[3] + 1j * y[4], y[2], y[5]
    k, A, V = TABLE_I, 0.12 * 0.069, abs(y[3] + 1j * y[4])
    v_hat = x_dot / V if V else 0j
    alpha, q = theta - np.angle(x_dot), 500 * A * V**2
    T = k.C_T * 500 * A * f**2 * np.exp(1j * (theta + phi))
    L = q * k.C_La * np.sin(2 * alpha) * v_hat * 1j
    D = -q * (k.C_D0 + k.C_Da * (1 - np.cos(2 * alpha))) * v_hat
    M = q * k.C_Ma * np.sin(2 * alpha) - k.C_Md * theta_dot * abs(theta_dot)
    N = ((L + D) * np.conj(1j * np.exp(1j * theta))).real
    a, arm = (T + L + D) / 0.68, 0.12 + 0.04 - 0.331 / 4
    return [x_dot.real, x_dot.imag, theta_dot, a.real, a.imag, (M + N * arm) / 0.0095]


def test_motion_is_that_of_the_published_equations():
    found = swim(lanes_at(30.0, -15.0), 6)[-1, :6]
    for k, phi in enumerate(np.radians([30.0, -15.0])):
        start = [3, 1.5, -phi, 0, 0, 0]
        exact = solve_ivp(published_rates, (0, 6), start, args=(phi, 5.0), rtol=1e-9, atol=1e-11)
        np.testing.assert_allclose(found[:, k] - [0, 0, phi, 0, 0, 0], exact.y[:, -1], atol=2e-5)
        assert found[5, k] * phi < 0  # positive angles turn clockwise


@pytest.mark.parametrize("robot", [PAPER_ROBOT, FINNED_ROBOT])
def test_straight_start_from_rest_is_the_closed_form(robot):
    speed = 5.0 * np.sqrt(TABLE_I.C_T / TABLE_I.C_D0)
    thrust = TABLE_I.C_T * 500 * 0.12 * 0.069 * 5.0**2
    found = swim(lanes_at(0.0), 6, robot)[:, :, 0]
    t = np.arange(len(found)) * DT
    np.testing.assert_allclose(found[:, 3], speed * np.tanh(thrust * t / (0.68 * speed)), atol=1e-7)
    assert np.all(found[:, 1] == 1.5)


def test_straight_swimming_is_unstable_as_stated_and_stable_with_a_fin():
    assert growth_rate(PAPER_ROBOT, 5.82) == pytest.approx(3.6, abs=0.1)
    assert growth_rate(FINNED_ROBOT) < 0


def is_odd(form) -> bool:
    return form.cause in {"trim_moment", "port_starboard_asymmetry", "pool_gyre"} or (
        form.name in {"offset_constant", "pulsating_moment"}
    )


def mirror_image(h: HiddenCause) -> HiddenCause:
    """The cause as a mirror along the pool shows it."""
    odd = {"way", "turn", "shear", "direction"}
    values = {k: -v if k in odd else 1 - v if k == "along" else v for k, v in h.parameters.items()}
    return replace(h, strength=-h.strength if is_odd(h.form) else h.strength, parameters=values)


def mirrored_rates(h: HiddenCause, mirrored: HiddenCause) -> tuple[np.ndarray, np.ndarray]:
    state, lanes, t = random_states(6), lanes_at(*np.linspace(-40, 40, 6)), np.full(6, 0.7)
    memory = 1 if h.form.cause == "stall" else -1  # share of detached flow, or lift
    flip = np.array([1, -1, -1, 1, -1, -1, memory, memory])[:, None]
    there = state * flip
    there[1] += POOL[1]
    found = rates(there, t, replace(lanes, phi=-lanes.phi), FINNED_ROBOT, [mirrored])
    return found, rates(state, t, lanes, FINNED_ROBOT, [h]) * flip


@pytest.mark.parametrize("form", MOTION_FORMS, ids=lambda f: f.name)
def test_even_laws_are_mirror_symmetric_and_odd_laws_change_sign(form):
    h = cause_of(form)
    np.testing.assert_allclose(*mirrored_rates(h, mirror_image(h)), atol=1e-10)
    if is_odd(form):
        found, expected = mirrored_rates(h, h)
        assert np.abs(found - expected).max() > 1e-3


@pytest.mark.parametrize("cause", ["crossflow_drag", "linear_yaw_damping", "viscous_drag",
                                   "wave_drag", "coulomb_friction"])  # fmt: skip
def test_drag_laws_take_energy(cause):
    state, lanes, t = random_states(6), lanes_at(*np.zeros(6)), np.ones(6)
    plain = rates(state, t, lanes, PAPER_ROBOT, ())
    for form in (f for f in plan.CATALOGUE if f.cause == cause):
        extra = rates(state, t, lanes, PAPER_ROBOT, [cause_of(form)]) - plain
        power = 0.68 * (extra[3:5] * state[3:5]).sum(axis=0) + 0.0095 * extra[5] * state[5]
        assert np.all(power <= 1e-12)
        assert power.min() < -1e-6


@pytest.mark.parametrize("seed", range(3))
def test_camera_is_that_of_opencv_and_refraction_is_undone(seed):
    camera, points = optics.draw_camera(np.random.default_rng(seed), POOL), optics.corners(POOL)
    (fx, fy), (cx, cy) = camera.focal, camera.middle
    matrix, R = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), camera.rotation
    places = np.column_stack([points.real, points.imag, np.full(4, 0.05)])
    pose = cv2.Rodrigues(R)[0], -R @ np.array(camera.place)
    expected = cv2.projectPoints(places, *pose, matrix, np.array(camera.distortion))[0][:, 0]
    marks = optics.image_of(points, 0.05, camera)
    np.testing.assert_allclose(np.column_stack([marks.real, marks.imag]), expected, atol=1e-6)
    moved = replace(camera, place=(3.1, 1.4, camera.place[2] + 0.05))
    found = optics.with_pose_from_corners(moved, marks, POOL, 0.05)
    np.testing.assert_allclose(found.place, camera.place, atol=1e-5)
    pixels = optics.image_under_water(points, 0.2 + np.zeros(4), camera, 1.333)
    located = [optics.point_under_water(pixels, 0.2, camera, index) for index in (1.333, 1.0)]
    np.testing.assert_allclose(located[0], points, atol=1e-8)
    assert np.abs(located[1] - points).max() > 5e-3


def setting_with(*hidden: HiddenCause) -> detector.Setting:
    view = studies._draw_view(np.random.default_rng(3), POOL, 0.05)
    water, tracker = Gusts(3e-3, 1e-2, 2.0), footage.Tracker(0.4, 0.4, 0.3, 0.01, 0.01)
    return detector.Setting(lanes_at(25.0, -15.0), FINNED_ROBOT, hidden, view, water, tracker, 60.0)


def test_poses_are_seen_as_they_are_and_every_fault_is_seen():
    setting = setting_with()
    states = swim(setting.lanes, 3, FINNED_ROBOT)
    grid = np.arange(len(states)) * DT

    def seen(*hidden: HiddenCause) -> np.ndarray:
        view = footage.with_faults(setting.view, hidden)
        pixels = footage.images(grid[::60], grid, states, setting.lanes, FINNED_ROBOT,
                                hidden=hidden, view=view)  # fmt: skip
        return footage.pose_seen(pixels, view)

    right, angles = seen(), np.tile(setting.lanes.phi, (grid[::60].size, 1))
    exact = np.stack([*np.moveaxis(states[::60, :3], 1, 0), angles])
    np.testing.assert_allclose(right, exact, atol=5e-3)
    for h in (cause_of(f) for f in plan.CATALOGUE if f.kind == MEASUREMENT):
        np.testing.assert_allclose(seen(h.scaled(0.0)), right, atol=1e-6)
        assert np.abs(seen(h) - right).max() > 1e-4


@pytest.mark.parametrize("name", ["drag_linear", "crossflow_square"])
def test_sensitivity_of_the_detector_is_that_of_simulating_again(name):
    h = cause_named(name)
    setting = setting_with(h)
    first = swim(setting.lanes, 1, FINNED_ROBOT, [h])[-1]

    def path(strength: float) -> np.ndarray:
        return swim(setting.lanes, 2, FINNED_ROBOT, [h.scaled(strength)], first)[::4]

    states, again = path(1.0), (path(1.02) - path(0.98))[-1, :6] / 0.04
    grid = np.arange(len(states)) * 4 * DT
    system = detector._system(setting, grid, states)
    transition, integral = detector._steps((system[1:] + system[:-1]) / 2, grid[1])
    push = detector._sensitivities(setting, grid, states, seen=False)[..., -1].swapaxes(1, 2)
    change = np.zeros((2, detector.SIZE, 1))
    for n in range(len(grid) - 1):
        middle = (push[n] + push[n + 1])[..., None] / 2
        change = transition[n] @ change + integral[n][..., :8] @ middle
    np.testing.assert_allclose(change[:, :6, 0].T, again, rtol=0.02, atol=2e-4)
    assert np.abs(again[:3]).max() > 5e-3


def short_plan(rng, robot, pool, *, two_heads, draw=studies.draw_plan):
    """The first nine trials, of 5 s."""
    full = draw(rng, robot, pool, two_heads=two_heads)
    rows = {f.name: getattr(full, f.name)[:9] for f in fields(full) if f.name != "lanes"}
    lane = {f.name: getattr(full.lanes, f.name)[:9] for f in fields(Lanes) if f.name != "pool"}
    rows["duration"] = np.full(9, 5.0)
    return replace(full, **rows, lanes=replace(full.lanes, **lane))


@pytest.fixture(scope="module")
def generated_studies(tmp_path_factory):
    """A null and a study with a hidden drag, of nine short trials."""
    folder = tmp_path_factory.mktemp("flume")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(studies, "draw_plan", short_plan)
        patch.setattr(studies, "LEAST_TRIAL_S", 4.0)
        patch.setattr(studies, "STEPS_PER_FRAME", 2)
        bare = [i for i in range(20) if not plan.study_kind(9, i)[1]]
        drag = cause_named("drag_linear").form
        yield folder, [generate(9, bare[k], folder, forms=f) for k, f in enumerate(([], [drag]))]


def test_files_are_accepted_by_the_tool_and_truths_have_the_keys_of_the_scores(generated_studies):
    folder, truths = generated_studies
    assert [[c["name"] for c in truth["causes"]] for truth in truths] == [[], ["viscous_drag"]]
    assert [truth["group"] for truth in truths] == ["null", "single"]
    low, high = studies.SIGMA_RANGE
    assert low <= truths[1]["causes"][0]["sigma"] <= high
    keys = {"study", "generator", "seed", "index", "group", "fin", "trials", "causes", "unlisted",
            "coefficients", "stability_per_s", "noise", "logged"}  # fmt: skip
    for truth in truths:
        path = folder / "truth" / f"{truth['study']}.json"
        assert json.loads(path.read_text()) == json.loads(json.dumps(truth))
        assert set(truth) == keys
        done = CliRunner().invoke(main, ["check", str(folder / "studies" / truth["study"])])
        assert done.exit_code == 0, done.output
        assert "no error found in the files" in done.output


def test_a_study_is_reproduced_from_seed_and_index(generated_studies, tmp_path):
    folder, truths = generated_studies
    generate(9, truths[0]["index"], tmp_path, forms=[])
    assert_same_files(tmp_path, folder)
