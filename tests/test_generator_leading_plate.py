"""The generator `leading_plate`: motion, camera, detector, plans, files and truths."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from bluekoi.cli import main as bluekoi
from validation.generators.leading_plate import generate
from validation.generators.leading_plate.here import Setting
from validation.generators.leading_plate.kalman import Linear, Noise, significance, whitened
from validation.generators.leading_plate.motion import ROWS, Plant, advance, simulate, slopes
from validation.generators.leading_plate.optics import corner_points, draw_camera, with_pose_of
from validation.generators.leading_plate.plan import choices, draw_plan
from validation.generators.leading_plate.registry import FAMILIES, NAMES, draw_law, probe_law
from validation.generators.leading_plate.robots import draw_fin, draw_robot, straight_growth
from validation.generators.leading_plate.sight import apparent, true_scene

POOL = (4.0, 3.0)


@pytest.fixture
def robot():
    return draw_robot(np.random.default_rng(5))


def setting_for(robot, angles, thrust=1.0, coefficients=1.0):
    count = len(angles)
    ones = np.ones(count)
    fin = [robot.fin.strength, robot.fin.arm] if robot.fin else [0, 0]
    return Setting(
        phi=np.radians(angles), flap=robot.flap * ones, full=robot.flap * ones,
        head=robot.head_length * ones, thrust=thrust * ones, delay=0 * ones, since=0 * ones,
        order=0.5 * ones, span=10 * ones, fin=np.outer(fin, ones),
        coefficients=np.outer(robot.coefficients * coefficients, ones), push=np.zeros((3, count)),
        swirl=np.zeros((7, 1, count)), jolts=np.zeros((3, 1, count)),
    )  # fmt: skip


def start_of(columns, *values):
    state = np.zeros((ROWS, columns))
    state[0], state[1], state[2] = 2.0, 1.5, 0.4
    state[3:6] = np.array(values)[:, None] if values else 0
    return state


def test_loads_are_those_of_the_published_equations(robot):
    """Equations 1 to 8 with angles, in world axes."""
    state = start_of(1, 0.3, -0.08, 0.4)
    got = slopes(Plant(robot, POOL), setting_for(robot, [25.0]), 0.0, state)[:, 0]
    C_T, C_D0, C_Da, C_La, C_Ma, C_Md = robot.coefficients
    theta, v = 0.4, (0.3 - 0.08j) * np.exp(0.4j)
    half_area = 500 * robot.head_length * robot.head_span
    q, v_hat, alpha = half_area * abs(v) ** 2, v / abs(v), theta - np.angle(v)
    T = C_T * half_area * robot.flap**2 * np.exp(1j * (theta + np.radians(25)))
    LD = q * C_La * np.sin(2 * alpha) * v_hat * 1j
    LD -= q * v_hat * (C_D0 + C_Da * (1 - np.cos(2 * alpha)))
    M = q * C_Ma * np.sin(2 * alpha) - C_Md * 0.16
    arm = 0.75 * robot.head_length + robot.hinge_to_com - (
        robot.body_length - robot.head_length) / 4  # fmt: skip
    spin = (M + arm * (LD * np.conj(1j * np.exp(1j * theta))).real) / robot.inertia
    ground = 0.3 - 0.08j
    pull = (got[3] + 1j * got[4] + 0.4j * ground) * np.exp(1j * theta) * robot.mass
    np.testing.assert_allclose(pull, T + LD, rtol=1e-6)
    assert got[5] == pytest.approx(spin, rel=1e-6)


def test_straight_start_is_a_hyperbolic_tangent_and_turns_mirror(robot):
    times = np.linspace(0, 8, 81)
    found = simulate(Plant(robot, POOL), setting_for(robot, [0, 30, -30]), start_of(3), times)
    rise = robot.drag / robot.mass / robot.speed
    np.testing.assert_allclose(
        found[3, 0], robot.speed * np.tanh(rise * times), atol=2e-4 * robot.speed
    )
    assert found[5, 1, -1] < 0
    np.testing.assert_allclose(found[5, 1], -found[5, 2], atol=1e-5)


@pytest.mark.parametrize("form", ["ellipsoid", "strip"])
def test_coasting_with_added_mass_keeps_energy(robot, form):
    law = replace(draw_law(np.random.default_rng(1), "added_mass"), form=form, size=0.5)
    plant = Plant(robot, POOL, (law,))
    setting = setting_for(robot, [0.0], thrust=0.0, coefficients=0.0)
    found = simulate(plant, setting, start_of(1, 0.3, 0.1, 0.5), np.linspace(0, 5, 20))[:, 0]
    u, v, r = found[3:6]
    sway_added_mass = 0.5 * robot.mass
    surge_added_mass, sway_yaw_coupling = 0.12 * sway_added_mass, 0.0
    if form != "ellipsoid":
        surge_added_mass, sway_yaw_coupling = 0.0, -0.25 * sway_added_mass * robot.core_length
    energy = ((robot.mass + surge_added_mass) * u**2 + (robot.mass + sway_added_mass) * v**2
              + 1.4 * robot.inertia * r**2) / 2 + sway_yaw_coupling * v * r  # fmt: skip
    np.testing.assert_allclose(energy, energy[0], rtol=1e-5)


def test_growth_is_that_of_the_motion_and_a_fin_damps(robot):
    rng = np.random.default_rng(1)
    fin = next(f for f in (draw_fin(rng, robot) for _ in range(50)) if f)
    assert straight_growth(robot, None) > 0 > straight_growth(robot, fin)
    start = start_of(1, robot.speed, 1e-6, 0.0)
    times = np.array([0.0, 3.0, 3.5])
    w = simulate(Plant(robot, POOL), setting_for(robot, [0.0]), start, times)[4, 0] * 1e6
    growth = np.log(np.abs(w[2] / w[1])) / 0.5
    assert growth == pytest.approx(straight_growth(robot, None), rel=0.05)


def test_every_law_moves_the_robot_and_stays_finite(robot):
    angles = np.array([0.0, 35.0, -35.0])
    state = start_of(3, 0.8 * robot.speed, -0.35 * robot.speed, 0.4)
    state[0], state[1], state[8] = 0.5, 1.0, 7.0
    setting = setting_for(robot, angles)
    setting = setting.but(head=1.4 * setting.head, since=0.5 + setting.since)
    plain = advance(Plant(robot, POOL), setting, state, 0.5, steps=25)
    for family in FAMILIES.values():
        assert len(family.forms) >= 2
        for form in family.forms if family.name != "sinking" else ():
            law = replace(probe_law(family.name), form=form, size=family.high)
            moved = advance(Plant(robot, POOL, (law,)), setting, state, 0.5, steps=25)
            assert np.isfinite(moved).all()
            assert np.abs(moved - plain).max() > 1e-5, (family.name, form)


@pytest.mark.parametrize("fisheye", [False, True])
def test_what_is_filmed_is_located(robot, fisheye):
    camera = draw_camera(np.random.default_rng(3), POOL, fisheye=fisheye, height=0.04)
    x, y = np.meshgrid(np.linspace(0.1, 3.9, 7), np.linspace(0.1, 2.9, 6))
    places = np.stack([x, y], axis=-1)
    pixels = camera.film(places, 0.2)
    assert (pixels > 0).all()
    np.testing.assert_allclose(camera.locate(pixels, 0.2), places, atol=1e-7)
    marks = corner_points(POOL, 0.04)
    moved = replace(camera, position=camera.position + 0.05, turn=camera.turn + 0.01)
    found = with_pose_of(moved, marks, camera.project(marks))
    np.testing.assert_allclose(found.position, camera.position, atol=1e-5)
    scene, setting = true_scene(robot, POOL, camera, 0.05, 0.04), setting_for(robot, [20.0])
    law = probe_law("scale_error")
    place, core = np.array([[2 + 1.5j]]), np.array([[0.3]])
    _, _, ratio = apparent((law,), scene, setting, np.zeros((1, 1)), place=place, core=core)
    assert ratio[0, 0] == pytest.approx(1 + law.size, rel=1e-3)


def test_noise_of_the_detector_is_whitened():
    rng = np.random.default_rng(0)
    trials, intervals = 40, 50
    moves = np.tile(np.eye(6), (trials, intervals, 1, 1))
    moves[..., 0, 3] = moves[..., 1, 4] = moves[..., 2, 5] = 0.2
    shape = (trials, intervals)
    linear = Linear(moves, np.zeros((*shape, 6, 3)), np.zeros((*shape, 6, 2)),
                    np.ones(shape, dtype=bool))  # fmt: skip
    noise = Noise(np.full(3, 1e-3), np.full(3, 2e-3), 0.6, np.zeros(3), 0.5, np.full(6, 0.01),
                  1e-9, 1e-9)  # fmt: skip
    slow = rng.normal(0, 2e-3, (trials, 3))
    seen = np.zeros((trials, intervals, 3, 1))
    start = rng.normal(0, 0.01, (trials, 6))
    for k in range(intervals):
        place = start[:, :3] + 0.2 * k * start[:, 3:]
        seen[:, k, :, 0] = place + slow + rng.normal(0, 1e-3, (trials, 3))
        slow = 0.6 * slow + rng.normal(0, 2e-3 * 0.8, (trials, 3))
    white = whitened(linear, noise, np.zeros((trials, intervals, 6, 1)), seen)
    assert white.std() == pytest.approx(1.0, abs=0.04)
    column = rng.normal(0, 1, 50)
    assert significance(column, np.stack([column, np.ones(50)], axis=1)) < 1e-9


def test_mix_of_a_block():
    plans = [draw_plan(4, k) for k in range(20)]
    assert Counter(p.group for p in plans) == {
        "null": 3, "one": 7, "two": 6, "faint": 2, "unlisted": 2
    }  # fmt: skip
    assert sum(p.fin for p in plans) == 10
    for plan in plans:
        names = choices(plan, 0)
        assert len(set(names)) == plan.count
        assert plan.group == "unlisted" or set(names) <= set(NAMES)


def small_null(seed):
    plans = {k: draw_plan(seed, k) for k in range(80)}
    return next(k for k, p in plans.items() if p.group == "null" and p.few_trials)


def test_same_seed_gives_same_files_and_an_empty_truth(tmp_path):
    truths = [generate(9, small_null(9), tmp_path / part) for part in ("a", "b")]
    files = [sorted(p for p in (tmp_path / part).rglob("*") if p.is_file()) for part in ("a", "b")]
    assert [p.read_bytes() for p in files[0]] == [p.read_bytes() for p in files[1]]
    truth = truths[0]
    assert {"study", "generator", "group", "fin", "trials", "causes", "verdict"} <= truth.keys()
    assert "unlisted" not in truth
    assert [c["name"] for c in truth["causes"]] == ["tail_fin_lift"] * truth["fin"]


@pytest.mark.long
def test_files_pass_check(tmp_path):
    study = tmp_path / "studies" / generate(9, small_null(9), tmp_path)["study"]
    found = CliRunner().invoke(bluekoi, ["check", str(study)])
    assert found.exit_code == 0, found.output
