"""The basin's generator: its mechanics, its laws, its camera, its detector and its files."""

from __future__ import annotations

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial.transform import Rotation
from study_files import assert_same_files

from bluekoi.cli import main
from validation.generators.towing_basin import generate, ideal, plan, studies, trials
from validation.generators.towing_basin.camera import draw_camera, pool_corners
from validation.generators.towing_basin.filming import (
    FilmedMotion,
    Tracker,
    detections,
    draw_scene,
    perceived_poses,
    with_measurement_errors,
)
from validation.generators.towing_basin.fins import FINS, Fin, fin_force
from validation.generators.towing_basin.form import (
    MEASUREMENT,
    PHYSICS,
    HiddenCause,
    ParallelTrials,
)
from validation.generators.towing_basin.motion import STEP_S, advance, rates, simulate_motion
from validation.generators.towing_basin.robots import Robot, draw_robot, growth_rate, with_fin
from validation.generators.towing_basin.water import RandomAccelerations, draw_accelerations
from validation.generators.towing_basin.writing import motor_log

PAPER_ROBOT = Robot()
POOL = (6.0, 3.0)


def still_water_trials(*angles_deg: float, hertz: float = 5.82) -> ParallelTrials:
    count = len(angles_deg)
    return ParallelTrials(np.radians(angles_deg), np.full(count, hertz), np.full(count, 0.12),
                 np.full(count, 3 + 1.5j), np.zeros(count), POOL)  # fmt: skip


def form_of(cause: str, name: str):
    return next(f for f in plan.CATALOGUE if (f.cause, f.name) == (cause, name))


def law_of(cause: str, name: str, size: float) -> HiddenCause:
    own = form_of(cause, name)
    return HiddenCause(own, size, {n: 0.5 * (a + b) for n, (a, b) in own.shape.items()})


def simulate_in_calm_water(
    own: ParallelTrials, seconds: float, robot: Robot = PAPER_ROBOT, hidden=()
):
    count = own.angle.size
    pushes = np.zeros((round(seconds / STEP_S), 3, count))
    return simulate_motion(own, robot, hidden, first=np.zeros((3, count)), pushes=pushes)


def random_states(count: int) -> np.ndarray:
    rng = np.random.default_rng(4)
    state = rng.normal(size=(8, count)) * np.array([0.3, 0.3, 1, 0.2, 0.2, 0.6, 0.2, 0.2])[:, None]
    state[:2] += np.array([[3.0], [1.5]])
    return state


def test_rates_are_those_of_the_published_equations():
    own, state = still_water_trials(*np.linspace(-45, 45, 7)), random_states(7)
    k, phi, A = PAPER_ROBOT.coefficients, own.angle, 0.12 * 0.069
    theta, v, r = state[2] - phi, state[3] + 1j * state[4], state[5]
    alpha, q = np.angle(np.exp(1j * theta) / v), 500 * A * np.abs(v) ** 2
    L = q * k.C_La * np.sin(2 * alpha) * v / np.abs(v) * 1j
    D = -q * (k.C_D0 + k.C_Da * (1 - np.cos(2 * alpha))) * v / np.abs(v)
    T = k.C_T * 500 * A * 5.82**2 * np.exp(1j * (theta + phi))
    a = (T + L + D) / PAPER_ROBOT.mass
    N = np.real((L + D) * np.conj(1j * np.exp(1j * theta)))
    arm = 0.12 + 0.04 - 0.331 / 4
    angular = (
        q * k.C_Ma * np.sin(2 * alpha) - k.C_Md * r * np.abs(r) + N * arm
    ) / PAPER_ROBOT.inertia
    found = rates(np.zeros(7), state, own, PAPER_ROBOT)
    np.testing.assert_allclose(found[3] + 1j * found[4], a, rtol=1e-12)
    np.testing.assert_allclose(found[5], angular, rtol=1e-12)


def test_straight_speed_is_that_of_thrust_and_drag():
    states = simulate_in_calm_water(still_water_trials(0.0), 10)
    k = PAPER_ROBOT.coefficients
    assert states[-1, 3, 0] == pytest.approx(5.82 * np.sqrt(k.C_T / k.C_D0), rel=2e-3)
    assert states[-1, 1, 0] == 1.5


def test_positive_head_angles_turn_clockwise_and_thrust_gives_the_power_that_drag_takes():
    own, robot = still_water_trials(30.0, -30.0), with_fin(np.random.default_rng(1), PAPER_ROBOT)
    states = simulate_in_calm_water(own, 12, robot)
    assert states[-1, 5, 0] < -0.1
    assert states[-1, 5, 0] == pytest.approx(-states[-1, 5, 1])
    change = rates(np.full(2, 12.0), states[-1], own, robot)
    power = PAPER_ROBOT.mass * (change[3:5] * states[-1, 3:5]).sum(axis=0)
    assert np.abs(power).max() < 1e-3


def test_straight_swimming_is_unstable_without_a_fin_and_stable_with_one():
    assert growth_rate(PAPER_ROBOT, 5.82) > 1
    for seed in range(4):
        assert growth_rate(with_fin(np.random.default_rng(seed), PAPER_ROBOT)) < 0


def test_integration_is_of_fourth_order():
    own = still_water_trials(30.0)
    start = np.zeros((8, 1))
    start[3], start[5] = 0.3, -0.2  # r |r| is smooth away from zero

    def end(step: float) -> np.ndarray:
        state = start
        for k in range(round(1 / step)):
            state = advance(np.full(1, k * step), state, own, PAPER_ROBOT, step=step)
        return state[:6]

    exact = end(1 / 400)
    coarse, fine = (np.abs(end(step) - exact).max() for step in (1 / 20, 1 / 40))
    assert 12 < coarse / fine < 24


@pytest.mark.parametrize("fin_law", FINS)
def test_fins_are_mirror_symmetric_and_oppose_sideways_flow(fin_law):
    fin = Fin(fin_law, 0.01, 0.12)
    flow = np.array([0.4 + 0.05j, 0.3 + 0.2j, 0.2 - 0.1j])
    rate = np.array([0.0, 0.5, -0.3])
    force, moment = fin_force(flow, rate, fin)
    mirrored, turned = fin_force(np.conj(flow), -rate, fin)
    np.testing.assert_allclose(mirrored, np.conj(force))
    np.testing.assert_allclose(turned, -moment)
    assert np.all(force.imag * (flow.imag - 0.12 * rate) < 0)


def mirrored_rates(hidden: list[HiddenCause]) -> tuple[np.ndarray, np.ndarray]:
    state, own = random_states(6), still_water_trials(*np.linspace(-40, 40, 6))
    flip = np.array([1, -1, -1, 1, -1, -1, -1, -1.0])[:, None]
    mirrored = state * flip
    mirrored[1] += POOL[1]
    other = replace(own, angle=-own.angle, start=np.conj(own.start) + 1j * POOL[1])
    t = np.full(6, 0.7)
    return rates(t, mirrored, other, PAPER_ROBOT, hidden), rates(
        t, state, own, PAPER_ROBOT, hidden
    ) * flip


def symmetric_forms():
    return [f for f in plan.CATALOGUE if f.kind == PHYSICS and not f.odd]


@pytest.mark.parametrize("own", symmetric_forms(), ids=lambda f: f"{f.cause}-{f.name}")
def test_even_laws_are_mirror_symmetric(own):
    np.testing.assert_allclose(
        *mirrored_rates([law_of(own.cause, own.name, own.start)]), atol=1e-10
    )


def test_odd_laws_tell_the_sides_apart():
    found, expected = mirrored_rates([law_of("trim_moment", "speed", 0.01)])
    assert np.abs(found - expected).max() > 1e-3


@pytest.mark.parametrize("cause", ["viscous_drag", "wave_drag", "coulomb_friction",
                                   "crossflow_drag", "linear_yaw_damping"])  # fmt: skip
def test_passive_forces_take_energy(cause):
    state, own = random_states(6), still_water_trials(*np.zeros(6))
    plain = rates(np.ones(6), state, own, PAPER_ROBOT)
    for f in (f for f in plan.CATALOGUE if f.cause == cause):
        extra = rates(np.ones(6), state, own, PAPER_ROBOT, [law_of(cause, f.name, f.start)]) - plain
        power = (
            PAPER_ROBOT.mass * (extra[3:5] * state[3:5]).sum(0)
            + PAPER_ROBOT.inertia * extra[5] * state[5]
        )
        assert np.all(power <= 1e-12)
        assert power.min() < 0


def test_fifteen_causes_have_three_forms_and_kinds_have_their_shares():
    forms = [f.cause for f in plan.CATALOGUE if f.kind in {PHYSICS, MEASUREMENT}]
    assert sum(forms.count(c) >= 3 for c in set(forms)) >= 28
    assert len(FINS) >= 5
    kinds = [plan.study_kind(3, i) for i in range(40)]
    count = {g: sum(k.group == g for k in kinds) for g in {k.group for k in kinds}}
    assert count == {"null": 8, "single": 18, "pair": 6, "measurement": 4, "unlisted": 4}
    assert sum(k.fin for k in kinds) == 20
    own = [plan.hidden_forms(np.random.default_rng(i), 3, k, 0) for i, k in enumerate(kinds)]
    singles = [f[0].cause for f, k in zip(own, kinds, strict=True) if k.group == "single"]
    assert len(set(singles)) == len(singles)


@pytest.mark.parametrize("seed", range(4))
def test_the_way_back_through_surface_and_lens_is_exact(seed):
    camera = draw_camera(np.random.default_rng(seed), POOL)
    plan_ = np.array([0.3 + 0.3j, 3 + 1.5j, 5.7 + 2.6j])
    pixels = camera.image_through_surface(plan_, 0.1, 1.333)
    np.testing.assert_allclose(camera.locate(pixels, 0.1, 1.333), plan_, atol=1e-7)
    assert np.all((pixels > 0) & (pixels < np.array(camera.size)))
    marks = camera.image(pool_corners(POOL), 0.1)
    found = replace(camera, eye=(3.0, 1.5, camera.eye[2] + 0.1)).posed(
        marks, pool_corners(POOL), 0.1
    )
    np.testing.assert_allclose(found.eye, camera.eye, atol=1e-4)


def test_the_lenses_are_those_of_opencv():
    seen = set()
    for seed in range(8):
        camera = draw_camera(np.random.default_rng(seed), POOL)
        seen.add(camera.model)
        points = np.array([[0.5, 0.5, 0.0], [3.0, 1.0, 0.0], [5.5, 2.5, 0.0]])
        turn = Rotation.from_rotvec(camera.turn)
        shift = -turn.apply(camera.eye)
        matrix = np.array([[camera.focal[0], 0, camera.centre[0]],
                           [0, camera.focal[1], camera.centre[1]], [0, 0, 1]])  # fmt: skip
        lens = cv2.fisheye.projectPoints if camera.model == "fisheye" else cv2.projectPoints
        args = (np.array(camera.turn), shift, matrix, np.array(camera.distortion))
        expected = lens(points[:, None], *args)[0].reshape(-1, 2)
        found = camera.image(points[:, 0] + 1j * points[:, 1], 0.0)
        np.testing.assert_allclose(found, expected, atol=1e-6)
    assert seen == {"pinhole", "fisheye"}


def test_tracking_errors_have_the_stated_size_and_memory_and_gaps():
    tracker = Tracker(0.5, 0.4, 0.5, 0.01, 0.01)
    exact = {"hinge": np.full((20000, 2), 500.0)}
    pixels, likelihood = detections(np.random.default_rng(2), exact, tracker, 30.0)["hinge"]
    good = likelihood > 0.95
    error = np.where(good[:, None], pixels - 500, np.nan)
    robust = 1.4826 * np.nanmedian(np.abs(error))
    assert robust == pytest.approx(np.hypot(0.5, 0.4), rel=0.1)
    assert 0.002 < np.mean(~(likelihood >= 0.1)) < 0.05
    pairs = error[:-3] * error[3:]
    inner = np.abs(error[:-3]) + np.abs(error[3:]) < 5
    assert pairs[inner].mean() == pytest.approx(0.16 * np.exp(-0.2), rel=0.25)


def test_log_wraps_at_the_flapping_frequency():
    times = np.arange(0, 5, STEP_S)
    t, angle = motor_log(np.random.default_rng(3), times, 4.0 * times, 4.9)
    assert np.allclose(np.diff(t), 0.005)
    seen = angle[np.isfinite(angle)]
    assert 0 <= seen.min() < seen.max() < 361
    assert np.sum(np.diff(seen) < -180) == pytest.approx(20, abs=1)


def test_repeated_turns_differ_by_the_stated_distance():
    unrest = trials.calibrate_unrest(np.random.default_rng(5), PAPER_ROBOT)
    own = still_water_trials(*[np.degrees(0.6)] * 60, hertz=4.0)
    pushes = draw_accelerations(np.random.default_rng(6), unrest, 180, 60)
    end = simulate_motion(own, PAPER_ROBOT, (), first=np.zeros((3, 60)), pushes=pushes)[-1, :2]
    off = np.sqrt(np.mean(np.sum((end - end.mean(axis=1, keepdims=True)) ** 2, axis=0)))
    low, high = trials.REPEATABILITY_RANGE_M
    assert 0.7 * low < off < 1.4 * high


@pytest.fixture(scope="module")
def filmed_turns():
    """A film of three turns, its noise, and the random accelerations in it."""
    rng = np.random.default_rng(8)
    own = still_water_trials(30.0, -30.0, 20.0)
    unrest = RandomAccelerations(2e-3, 1e-2, 0.4)
    pushes = draw_accelerations(rng, unrest, 300, 3)
    states = simulate_motion(own, PAPER_ROBOT, (), first=np.zeros((3, 3)), pushes=pushes)
    scene = draw_scene(rng, draw_camera(rng, POOL), PAPER_ROBOT, POOL)
    return FilmedMotion(states, own, PAPER_ROBOT, ()), ideal.Noise(unrest, scene, 30.0), pushes


def test_the_filter_knows_how_random_accelerations_move_the_robot(filmed_turns):
    film, noise, _ = filmed_turns
    t, states = ideal._knots(film)
    columns = film.lanes.columns()
    F = ideal._transition(t, states, columns, PAPER_ROBOT, noise.unrest)
    base = simulate_motion(
        film.lanes, PAPER_ROBOT, (), first=np.zeros((3, 3)), pushes=np.zeros((300, 3, 3))
    )
    P = np.zeros((3, ideal.STATE_SIZE, ideal.STATE_SIZE))
    accelerations = noise.unrest.deviations**2
    P[:, [6, 7, 8], [6, 7, 8]] = accelerations
    Q = P * (1 - np.exp(-2 * ideal.KNOT_STEPS * STEP_S / noise.unrest.memory))
    for j in range(60):
        P = F[:, j] @ P @ F[:, j].mT + Q
    count = 80
    many = still_water_trials(*[30.0] * count)
    pushes = draw_accelerations(np.random.default_rng(1), noise.unrest, 240, count)
    end = simulate_motion(many, PAPER_ROBOT, (), first=np.zeros((3, count)), pushes=pushes)[-1]
    spread = (end[:6] - base[240, :6, :1]).std(axis=1)
    np.testing.assert_allclose(spread, np.sqrt(np.diagonal(P[0])[:6]), rtol=0.35)


def test_sigma_grows_with_the_strength_and_falls_with_unrest(filmed_turns):
    film, noise, _ = filmed_turns
    ends = np.full(3, 5.0)

    def sigma(size: float, own: ideal.Noise = noise) -> float:
        hidden = (law_of("viscous_drag", "linear", size),)
        return ideal.detectability_sigmas(replace(film, hidden=hidden), own, ends)["viscous_drag"]

    assert sigma(0.0) == pytest.approx(0, abs=1e-9)
    assert sigma(0.2) == pytest.approx(2 * sigma(0.1), rel=0.02)
    rough = replace(noise, unrest=replace(noise.unrest, linear=2e-2, turning=1e-1))
    assert sigma(0.1, rough) < 0.5 * sigma(0.1)


def test_poses_are_seen_as_they_are_and_faults_are_seen(filmed_turns):
    film, noise, _ = filmed_turns
    t = np.arange(0, 4.5, 0.5)
    right = perceived_poses(film, noise.scene, with_measurement_errors(noise.scene, ()), t)
    expected = np.stack([film.pose(k, t)[0] for k in range(3)])
    assert np.abs(right[..., 0] + 1j * right[..., 1] - expected).max() < 3e-3
    np.testing.assert_allclose(right[..., 3], np.repeat(film.lanes.angle[:, None], 9, 1), atol=0.01)
    for f in (f for f in plan.CATALOGUE if f.kind == MEASUREMENT):
        own = plan.with_drawn_shape(np.random.default_rng(0), f)
        wrong = perceived_poses(film, noise.scene, with_measurement_errors(noise.scene, [own]), t)
        none = perceived_poses(
            film, noise.scene, with_measurement_errors(noise.scene, [own.sized(0.0)]), t
        )
        np.testing.assert_allclose(none, right, atol=1e-7)
        assert np.abs(wrong - right).max() > 1e-5


@pytest.fixture(scope="module")
def generated_studies(tmp_path_factory):
    """A null and a study with a hidden drag, of few short trials."""
    folder = tmp_path_factory.mktemp("basin")
    patch = pytest.MonkeyPatch()
    patch.setattr(trials, "MAX_TRIAL_S", 6.5)
    patch.setattr(trials, "TRIAL_COUNTS", (9,))
    patch.setattr(trials, "SHARE_TWO_HEADS", 0.0)
    bare = [i for i in range(20) if not plan.study_kind(9, i).fin]
    drag = form_of("viscous_drag", "linear")
    made = [generate(9, i, folder, forms=f) for i, f in zip(bare, ([], [drag]), strict=False)]
    yield folder, made
    patch.undo()


def test_files_are_accepted_by_the_tool(generated_studies):
    folder, truths = generated_studies
    for truth in truths:
        done = CliRunner().invoke(main, ["check", str(folder / "studies" / truth["study"])])
        assert done.exit_code == 0, done.output
        assert "no error found in the files" in done.output


def test_truths_have_the_keys_of_the_scores_and_sigma_in_range(generated_studies):
    folder, truths = generated_studies
    for truth, hidden in zip(truths, ([], ["viscous_drag"]), strict=True):
        path = folder / "truth" / f"{truth['study']}.json"
        assert json.loads(path.read_text()) == json.loads(json.dumps(truth))
        assert [c["name"] for c in truth["causes"]] == hidden
        low, high = studies.VISIBLE_SIGMA_RANGE
        assert all(low <= c["sigma"] <= high for c in truth["causes"])
        assert {"group", "trials", "unlisted", "generator", "coefficients", "fin"} <= set(truth)
        rows = (folder / "studies" / truth["study"] / "trials.csv").read_text().splitlines()
        assert len(rows) == truth["trials"] + 1 == 10
    assert truths[0]["group"] == "null"


def test_a_study_is_reproduced(generated_studies, tmp_path):
    folder, truths = generated_studies
    generate(9, truths[0]["index"], tmp_path, forms=[])
    assert_same_files(tmp_path, folder)


def test_robots_differ_and_stay_near_the_published_one():
    robots = [draw_robot(np.random.default_rng(i)) for i in range(20)]
    assert len({r.mass for r in robots}) == 20
    assert all(0.6 < r.mass < 0.76 and 0.3 < r.body_length < 0.36 for r in robots)
