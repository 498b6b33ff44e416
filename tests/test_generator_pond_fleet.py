"""The generator `pond_fleet`: motion, loads, water, camera, errors, plans, files and truths."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from bluekoi.cli import main as bluekoi
from validation.generators.pond_fleet import generate
from validation.generators.pond_fleet.camera import (
    corner_points,
    crossing,
    draw_camera,
    with_fitted_pose,
)
from validation.generators.pond_fleet.drag_laws import DRAG_FAMILIES
from validation.generators.pond_fleet.dynamics import (
    RATE,
    ROWS,
    SHAFT,
    SURGE,
    SWAY,
    THETA,
    Plant,
    X,
    Y,
    integrate,
)
from validation.generators.pond_fleet.eddies import draw_eddies
from validation.generators.pond_fleet.faults import FORMS, Scene, apparent, draw_fault
from validation.generators.pond_fleet.fins import FIN_FORMS, draw_fin, straight_growth
from validation.generators.pond_fleet.flow import Setting
from validation.generators.pond_fleet.law import Law
from validation.generators.pond_fleet.plan import FAMILIES, FAULTS, UNLISTED, draw_plan
from validation.generators.pond_fleet.robots import draw_robot
from validation.generators.pond_fleet.trials import draw_session

ADDED_MASS_FORMS = list(FAMILIES["added_mass"].forms)


@pytest.fixture
def robot():
    return draw_robot(np.random.default_rng(3))


def plant_for(robot, angles_deg, *laws, power=1.0, duration=None, coefficients=1.0, head=1.0):
    ones = np.ones(len(angles_deg))
    duration = duration or 12 * robot.body_time
    setting = Setting(power * robot.flap * ones, np.radians(angles_deg),
                      head * robot.head_length * ones, 0.5 * ones, duration * ones)  # fmt: skip
    fin = robot.fin
    return Plant(
        robot, (9 * robot.body_length, 7 * robot.body_length), setting,
        coefficients * np.outer(robot.coefficients, ones),
        (fin.area * fin.slope if fin else 0) * ones, (fin.arm if fin else 0) * ones, ones, laws,
    )  # fmt: skip


def start_of(robot, columns, surge=0.0, sway=0.0, turns=0.0):
    """Speeds in U0 and U0 / L, in the middle of the pool."""
    start = np.zeros((ROWS, columns))
    start[X], start[Y], start[THETA] = 4 * robot.body_length, 3 * robot.body_length, 0.4
    start[SURGE], start[SWAY] = surge * robot.speed, sway * robot.speed
    start[RATE] = turns / robot.body_time
    return start


def law_of(name, form, size=None, shape=0.5):
    family = (FAMILIES | UNLISTED)[name]
    return Law(family, form, np.sqrt(family.low * family.high) if size is None else size, shape)


def momenta(plant, state):
    """Impulse of body and water in the pool, and kinetic energy."""
    rigid = np.diag([plant.robot.mass, plant.robot.mass, plant.robot.inertia])
    motion = state[[SURGE, SWAY, RATE], 0]
    impulse = (rigid + plant.added[0][..., 0]) @ motion
    along = (impulse[0] + 1j * impulse[1]) * np.exp(1j * state[THETA, 0])
    turning = impulse[2] + state[X, 0] * along.imag - state[Y, 0] * along.real
    return np.array([along.real, along.imag, turning, motion @ impulse / 2])


@pytest.mark.parametrize("form", [None, *(f for f in ADDED_MASS_FORMS if f != "reduced_munk")])
def test_coasting_body_keeps_impulse_and_energy(robot, form):
    laws = [law_of("added_mass", form, 0.9)] if form else []
    plant = plant_for(robot, [30.0], *laws, power=0.0, coefficients=0.0)
    motion = integrate(plant, start_of(robot, 1, 0.8, 0.3, 0.7), 900)
    kept = np.array([momenta(plant, state) for state in motion.states])
    np.testing.assert_allclose(kept, np.broadcast_to(kept[0], kept.shape), rtol=1e-6, atol=1e-9)


def test_straight_speed_is_the_drawn_one(robot):
    plant = plant_for(robot, [0.0], duration=60 * robot.body_time)
    motion = integrate(plant, start_of(robot, 1), 1200)
    assert motion.states[-1, SURGE, 0] == pytest.approx(robot.speed, rel=1e-3)
    assert motion.states[-1, SHAFT, 0] == pytest.approx(60 * robot.body_time * robot.flap)


def test_coasting_by_quadratic_drag_is_the_known_curve(robot):
    plant = plant_for(robot, [0.0], power=0.0)
    motion = integrate(plant, start_of(robot, 1, surge=1.0), 300)
    slowing = robot.cruise_drag / robot.mass / robot.speed
    expected = robot.speed / (1 + slowing * motion.times[:, 0])
    np.testing.assert_allclose(motion.states[:, SURGE, 0], expected, rtol=1e-6)


def test_positive_head_angle_turns_clockwise_and_mirrors(robot):
    motion = integrate(plant_for(robot, [30.0, -30.0]), start_of(robot, 2), 400)
    assert motion.states[-1, RATE, 0] < 0
    np.testing.assert_allclose(motion.states[:, RATE, 0], -motion.states[:, RATE, 1], atol=1e-9)


def test_integrator_has_order_four(robot):
    finals = [
        integrate(plant_for(robot, [25.0]), start_of(robot, 1, 0.5), steps).states[-1, :3, 0]
        for steps in (240, 480, 1200)
    ]
    errors = [np.abs(final - finals[-1]).max() for final in finals[:-1]]
    assert np.log2(errors[0] / errors[1]) > 3.3


def test_interpolated_motion_passes_through_its_instants(robot):
    motion = integrate(plant_for(robot, [25.0, 0.0]), start_of(robot, 2), 200)
    np.testing.assert_allclose(
        motion.column_at(0, motion.times[:-1, 0]), motion.states[:-1, :, 0].T, atol=1e-12
    )


@pytest.mark.parametrize("family", DRAG_FAMILIES, ids=lambda f: f.name)
def test_damping_takes_energy(robot, family):
    for form in family.forms:
        plant = plant_for(robot, [20.0], Law(family, form, family.low, 0.5), power=0.0,
                          coefficients=0.0, duration=3 * robot.body_time)  # fmt: skip
        motion = integrate(plant, start_of(robot, 1, 0.9, 0.2, 0.5), 100)
        energy = np.array([momenta(plant, state)[-1] for state in motion.states])
        assert (np.diff(energy) < 0).all(), form


@pytest.mark.parametrize("name", [*FAMILIES, *UNLISTED])
def test_every_form_changes_the_motion(robot, name):
    family = (FAMILIES | UNLISTED)[name]
    assert len(family.forms) >= (2 if name in UNLISTED else 4)
    angles = [0.0, 35.0, -35.0]
    start, duration = start_of(robot, 3), 8 * robot.body_time
    plain = integrate(plant_for(robot, angles, head=1.4, duration=duration), start, 150)
    for form in family.forms:
        law = Law(family, form, family.high, 0.3)
        plant = plant_for(robot, angles, law, head=1.4, duration=duration)
        moved = integrate(plant, start, 150)
        assert np.isfinite(moved.states).all()
        shift = np.abs(moved.states[:, [X, Y]] - plain.states[:, [X, Y]]).max()
        assert shift > 1e-3 * robot.body_length, form


@pytest.mark.parametrize("form", FIN_FORMS)
def test_growth_is_that_of_the_simulated_motion(robot, form):
    rng = np.random.default_rng(1)
    fin = next(f for f in (draw_fin(rng, robot) for _ in range(50)) if f)
    finned = replace(robot, fin=replace(fin, form=form))
    plant = plant_for(finned, [0.0], duration=4 * robot.body_time)
    motion = integrate(plant, start_of(robot, 1, 1.0, 1e-7, 1e-7), 400)
    assert straight_growth(robot, None) > 0 > straight_growth(finned, finned.fin)
    assert abs(motion.states[-1, SWAY, 0]) < 3e-7 * robot.speed


def test_eddies_have_their_speed_and_no_divergence():
    eddies = draw_eddies(np.random.default_rng(1), 4000, 0.5, 0.002)
    x, y, t = np.full((3, 4000), 0.7)
    u, v = eddies(t, x, y)
    assert np.sqrt((u**2 + v**2).mean()) == pytest.approx(0.002, rel=0.05)
    d = 1e-5
    divergence = (eddies(t, x + d, y)[0] - eddies(t, x - d, y)[0]
                  + eddies(t, x, y + d)[1] - eddies(t, x, y - d)[1]) / (2 * d)  # fmt: skip
    np.testing.assert_allclose(divergence, 0, atol=1e-8)


@pytest.mark.parametrize("seed", range(8))
def test_filmed_points_are_located_where_they_were(seed):
    pool = (6.0, 4.0)
    camera = draw_camera(np.random.default_rng(seed), pool, 0.05)
    x, y = np.meshgrid(np.linspace(0.1, 5.9, 9), np.linspace(0.1, 3.9, 7))
    pixels = camera.film(x, y, 0.2, 1.333)
    assert (pixels > 0).all()
    assert (pixels < np.array(camera.size)).all()
    found = camera.locate(pixels, 0.2, 1.333)
    np.testing.assert_allclose(found, (x, y), atol=1e-6)


def test_bent_ray_obeys_snell():
    distance, height, depth = np.array([0.5, 3.0]), 4.0, 0.3
    reached = crossing(distance, height, depth, 1.333)
    air = reached / np.hypot(reached, height)
    water = (distance - reached) / np.hypot(distance - reached, depth)
    np.testing.assert_allclose(air, 1.333 * water, rtol=1e-9)


def test_pose_is_found_from_the_corners():
    pool = (6.0, 4.0)
    camera = draw_camera(np.random.default_rng(5), pool, 0.05)
    marks = corner_points(pool, 0.05)
    moved = replace(camera, position=camera.position + 0.1, turn=camera.turn + 0.02)
    found = with_fitted_pose(moved, marks, camera.project(marks))
    np.testing.assert_allclose(found.position, camera.position, atol=1e-5)


@pytest.mark.parametrize("name", FAULTS)
def test_every_error_of_measurement_moves_the_tracks(robot, name):
    rng = np.random.default_rng(2)
    pool = (9 * robot.body_length, 7 * robot.body_length)
    session = draw_session(rng, robot, pool, two_heads=False)
    scene = Scene(robot, session, pool, draw_camera(rng, pool, 0.0), 0.1 * robot.body_length, 0.0)
    seen = np.zeros((1, session.count, 24, 3))
    seen[..., 0] = np.linspace(2, 7, 24) * robot.body_length
    seen[..., 1] = 2 * robot.body_length
    assert len(FORMS[name]) >= 4
    for form in FORMS[name]:
        fault = replace(draw_fault(rng, name, session), form=form)
        if name == "lens_error" and form == "none_stated":
            continue  # nothing to leave out where the lens is ideal
        moved = apparent(fault, scene, seen) - seen
        assert np.isfinite(moved).all()
        assert np.abs(moved).max() > 0, form


def test_mix_of_a_block():
    plans = [draw_plan(4, k) for k in range(20)]
    assert Counter(p.group for p in plans) == {
        "null": 4, "one": 7, "two": 5, "unlisted": 2, "measurement": 2
    }  # fmt: skip
    assert sum(p.fin for p in plans) == 10
    assert sum(p.group == "two" and p.fault is not None for p in plans) == 1


@pytest.mark.long
def test_same_seed_gives_same_files_that_pass_check_and_an_empty_truth(tmp_path):
    index = next(
        k for k in range(20) if draw_plan(9, k).group == "null" and not draw_plan(9, k).fin
    )
    truths = [generate(9, index, tmp_path / part) for part in ("a", "b")]
    files = [sorted(p for p in (tmp_path / part).rglob("*") if p.is_file()) for part in ("a", "b")]
    assert [p.read_bytes() for p in files[0]] == [p.read_bytes() for p in files[1]]
    truth = truths[0]
    assert {"study", "generator", "group", "fin", "trials"} <= truth.keys()
    assert truth["causes"] == []
    assert "unlisted" not in truth
    assert truth["verdict"] == "none"
    study = tmp_path / "a/studies" / truth["study"]
    assert len((study / "trials.csv").read_text().splitlines()) == truth["trials"] + 1
    found = CliRunner().invoke(bluekoi, ["check", str(study)])
    assert found.exit_code == 0, found.output
