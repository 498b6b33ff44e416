"""The generator `race_track`: its motion, its optics, its floor, its files and truths."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from validation.generators.race_track import generate
from validation.generators.race_track.camera import draw_camera
from validation.generators.race_track.form import Law
from validation.generators.race_track.loads import Bench
from validation.generators.race_track.motion import CHI, TURNS, H, P, Z, at_rest, integrate
from validation.generators.race_track.plan import CAUSES, FAMILIES, UNLISTED, draw_plan
from validation.generators.race_track.robots import FIN_FORMS, draw_fin, draw_robot, straight_growth

POOL = (8.0, 5.0)


@pytest.fixture
def robot():
    return draw_robot(np.random.default_rng(3))


def bench_for(robot, angles_deg, *laws, power=1.0):
    ones = np.ones(len(angles_deg))
    return Bench(
        robot, POOL, np.outer(robot.coefficients, ones), power * robot.flap * ones,
        phi=np.radians(angles_deg), head=robot.head_length * ones, laws=laws,
    )  # fmt: skip


def swim(bench, duration=4.0, dt=1 / 100):
    ones = np.ones(len(bench.flap))
    return integrate(bench, at_rest(bench, (4 + 2.5j) * ones, 0.0 * ones), duration, dt)


def without_coefficients(bench):
    return replace(bench, coefficients=0 * bench.coefficients)


def law_of(name, form, size, shape=0.5):
    return Law((CAUSES | UNLISTED)[name], form, size, shape)


def test_robot_without_thrust_stays_at_rest(robot):
    path = swim(bench_for(robot, [0.0, 30.0], power=0.0))
    np.testing.assert_allclose(path.y[-1], path.y[0], atol=1e-12)


def test_straight_speed_is_the_published_one(robot):
    path = swim(bench_for(robot, [0.0]), duration=40 * robot.body_length / robot.speed, dt=1 / 30)
    assert abs(path.v[-1, 0]) == pytest.approx(robot.speed, rel=1e-3)


def test_positive_head_angle_turns_clockwise_and_mirrors(robot):
    path = swim(bench_for(robot, [30.0, -30.0]))
    assert path.r[-1, 0] < 0
    assert path.r[-1, 1] == pytest.approx(-path.r[-1, 0])


def test_impulse_of_body_and_water_is_kept_without_loads(robot):
    bench = without_coefficients(bench_for(robot, [0.0], law_of("added_mass", "strips", 0.8)))
    y = at_rest(bench, np.array([4 + 2j]), np.array([0.3]))
    y[P], y[H] = robot.mass * robot.speed * (1 + 0.4j), robot.inertia * 1.5
    path = integrate(bench, y, 3.0, 1 / 200)
    np.testing.assert_allclose(path.y[:, P], path.y[0, P] + 0 * path.y[:, P], rtol=1e-12)
    about_origin = path.y[:, H] + (np.conj(path.y[:, Z]) * path.y[:, P]).imag
    np.testing.assert_allclose(about_origin.real, about_origin.real[0, 0], rtol=1e-6)
    energy = _energy(bench, path)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-6)


def _energy(bench, path):
    """Kinetic energy of body and water: half of impulse times velocity."""
    turning = path.y[:, H].real * path.r
    return 0.5 * ((np.conj(path.v) * path.y[:, P]).real + turning)[:, 0]


def test_integrator_has_order_four(robot):
    ends = [
        swim(bench_for(robot, [25.0]), 2.0, dt).y[-1, [Z, CHI], 0]
        for dt in (1 / 10, 1 / 20, 1 / 40, 1 / 320)
    ]
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    assert np.log2(errors[1] / errors[2]) > 3.3


@pytest.mark.parametrize(
    "name",
    ["viscous_drag", "wave_drag", "coulomb_friction", "crossflow_drag", "linear_yaw_damping"],
)
def test_damping_takes_power(robot, name):
    family = CAUSES[name]
    for form in family.forms:
        law = Law(family, form, family.low, 0.5)
        bench = without_coefficients(bench_for(robot, [0.0], law))
        y = at_rest(bench, np.array([4 + 2j]), np.array([0.3]))
        y[P], y[H] = robot.mass * robot.speed * (0.8 + 0.3j), robot.inertia * 0.8
        energy = _energy(bench, integrate(bench, y, 1.0, 1 / 100))
        assert (np.diff(energy) < 0).all(), form


@pytest.mark.parametrize("family", [*FAMILIES, *UNLISTED.values()], ids=lambda f: f.name)
def test_every_form_changes_the_motion_and_stays_finite(robot, family):
    angles = [0.0, 35.0, -35.0]
    duration = 14 * robot.body_length / robot.speed
    plain = swim(bench_for(robot, angles), duration, 1 / 20)
    for form in family.forms:
        bench = bench_for(robot, angles, Law(family, form, family.high, 0.3))
        bench = replace(bench, head=1.5 * bench.head) if family.name == "thrust_area" else bench
        path = swim(bench, duration, 1 / 20)
        assert np.isfinite(path.y).all()
        assert np.abs(path.y[:, Z] - plain.y[:, Z]).max() > 1e-4, form


@pytest.mark.parametrize("form", FIN_FORMS)
def test_fin_makes_straight_swimming_stable(robot, form):
    finned = replace(robot, fin=draw_fin(np.random.default_rng(1), robot, form))
    assert straight_growth(robot, None) > 0 > straight_growth(finned, finned.fin)


def test_motor_turns_once_a_beat(robot):
    path = swim(bench_for(robot, [0.0]), 2.0)
    assert path.y[-1, TURNS, 0].real == pytest.approx(2 * robot.flap)


def test_refracted_ray_obeys_snell():
    camera = draw_camera(np.random.default_rng(2), POOL)
    dry = replace(camera, index=1.0)
    z, depth = np.array([1 + 1j, 7 + 4j]), np.array([0.2, 0.1])
    flat = np.stack([z.real, z.imag, -depth], axis=-1)
    np.testing.assert_allclose(dry.film(z, depth), camera.project(flat), atol=1e-6)
    raised = np.linalg.norm(camera.film(z, depth) - dry.film(z, depth), axis=-1)
    assert (raised > 1).all()


def test_mix_of_a_block():
    plans = [draw_plan(4, k) for k in range(20)]
    assert Counter(p.group for p in plans) == {
        "null": 3, "one": 8, "two": 5, "unlisted": 2, "measurement": 2
    }  # fmt: skip
    assert sum(p.fin for p in plans) == 10
    assert sum(p.group == "two" and p.fault is not None for p in plans) == 2


def test_same_seed_gives_same_files_and_a_truth(tmp_path):
    assert draw_plan(9, 2).group == "null"
    truths = [generate(9, 2, tmp_path / part) for part in ("a", "b")]
    assert truths[0] == truths[1]
    files = [sorted(p for p in (tmp_path / part).rglob("*") if p.is_file()) for part in ("a", "b")]
    assert [p.read_bytes() for p in files[0]] == [p.read_bytes() for p in files[1]]
    truth = truths[0]
    assert {"study", "generator", "group", "fin", "trials", "verdict", "causes"} <= truth.keys()
    named = [cause["name"] for cause in truth["causes"]]
    assert named == (["tail_fin_lift"] if truth["fin"] else [])
    assert truth["verdict"] == ("physics" if truth["fin"] else "none")
    study = tmp_path / "a/studies" / truth["study"]
    assert len((study / "trials.csv").read_text().splitlines()) == truth["trials"] + 1
