"""The generator `harbour_dock`: equations, laws, camera, mix of groups and files."""

from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from bluekoi.cli import main as bluekoi
from validation.generators.harbour_dock import engine, generate, study, unlisted
from validation.generators.harbour_dock.choose import CAUSES, LAWS, draw_names, group_and_fin
from validation.generators.harbour_dock.engine import Here, simulate, slopes, variant_set
from validation.generators.harbour_dock.optics import draw_camera, pose_matrix
from validation.generators.harbour_dock.plan import draw_trials
from validation.generators.harbour_dock.robots import draw_robot
from validation.generators.harbour_dock.typical import typical
from validation.generators.harbour_dock.view import Track, make_view, observe, skeleton, with_laws

POOL = (4.0, 3.0, 0.6)
TIMES = np.linspace(0, 0.23, 3)
UNLISTED = {force.__name__: force for force in unlisted.ALL}


def quiet_trials(robot, simulated):
    """Four trials without any error, at full power, from rest in the middle of the basin."""
    drawn = draw_trials(np.random.default_rng(2), robot, two_heads=False)
    ones = np.ones(4)
    start = np.outer(ones, [2.0, 1.5, 0.4, 0.0, 0.0, 0.0])
    return replace(
        drawn, power=100 * ones, phi=np.radians([0.0, 30.0, -30.0, 40.0]), head=robot.head * ones,
        flap=robot.full_flap * ones, duration=simulated * ones, simulated=simulated, pool=POOL,
        area=robot.head * robot.span * ones, arm=robot.arm(robot.head) * ones, start=start,
        servo_error=0 * ones, thrust_error=0 * ones, water=np.zeros((4, 40), dtype=complex),
    )  # fmt: skip


def motion_of(case):
    return simulate(case.robot, case.trials, [], variant_set(case.robot, case.trials, [], 1))


@pytest.fixture(scope="module")
def case():
    robot = draw_robot(np.random.default_rng(5), fin=False)
    found = SimpleNamespace(robot=robot, trials=quiet_trials(robot, 1.0))
    return SimpleNamespace(plain=motion_of(found), **vars(found))


def view_of(case, model="pinhole"):
    cameras = (draw_camera(np.random.default_rng(k), POOL) for k in range(99))
    camera = next(one for one in cameras if one.lens.model == model)
    view = make_view(np.random.default_rng(1), case.robot, case.trials, camera)
    return replace(view, lens_written=camera.lens, corner_noise=np.zeros((4, 2)))


def test_forces_are_those_of_the_published_equations(case):
    """Equations 1 to 8 in world axes."""
    robot = case.robot
    here = Here(robot, case.trials, [], variant_set(robot, case.trials, [], 1))
    state = np.tile(np.array([1.0, 2.0, 0.7, 0.25, -0.11, 0.6])[:, None, None], (1, 1, 4))
    got = slopes(here, state, 0.3)[:, 0, 3]
    C_T, C_La, C_D0, C_Da, C_Ma, C_Md = robot.coefficients.values()
    theta, v, A = 0.7, 0.25 - 0.11j, robot.head * robot.span
    q, v_hat, alpha = 500 * A * abs(v) ** 2, v / abs(v), theta - np.angle(v)
    T = C_T * 500 * A * robot.full_flap**2 * np.exp(1j * (theta + np.radians(40)))
    LD = q * C_La * np.sin(2 * alpha) * v_hat * 1j
    LD -= q * (C_D0 + C_Da * (1 - np.cos(2 * alpha))) * v_hat
    M = q * C_Ma * np.sin(2 * alpha) - C_Md * 0.36
    arm = robot.head + robot.hinge_to_com - robot.length / 4
    spin = (M + arm * (LD * np.conj(1j * np.exp(1j * theta))).real) / robot.inertia
    assert (got[3] + 1j * got[4]) * robot.mass == pytest.approx(T + LD, rel=1e-6)
    assert got[5] == pytest.approx(spin, rel=1e-6)


def test_straight_start_is_a_hyperbolic_tangent_and_turns_mirror(case):
    motion, robot = case.plain, case.robot
    rise = robot.coefficients["C_D0"] * 500 * robot.head * robot.span * robot.speed / robot.mass
    ahead = motion.velocity_x * np.cos(0.4) + motion.velocity_y * np.sin(0.4)
    expected = robot.speed * np.tanh(rise * motion.time)
    np.testing.assert_allclose(ahead[:, 0, 0], expected, atol=1e-4 * robot.speed)
    assert motion.theta[-1, 0, 1] < 0.39  # clockwise, from 0.4
    np.testing.assert_allclose(motion.theta[:, 0, 1:3].sum(axis=1), 0.8, atol=1e-9)


@pytest.fixture(scope="module")
def moving(case):
    """Under way, askew, turning, with a longer head, near a corner."""
    trials = quiet_trials(case.robot, 0.24)
    trials.head, trials.area = 1.4 * trials.head, 1.4 * trials.area
    trials.start[:] = 0.4, 0.5, 0.4, 0.8 * case.robot.speed, -0.3 * case.robot.speed, 0.5
    found = SimpleNamespace(robot=case.robot, trials=trials)
    found.view, found.plain = view_of(found), motion_of(found)
    found.typical = replace(typical(case.robot, trials, found.plain), top_speed=case.robot.speed)
    found.seen = {j: observe(found.view, Track(found.plain), TIMES, j) for j in (2, 3)}
    return found


@pytest.mark.parametrize("name", [*LAWS, *UNLISTED])
def test_every_form_changes_motion_or_view_and_no_size_nothing(moving, name):
    robot, trials, view, plain = moving.robot, moving.trials, moving.view, moving.plain
    laws = [(LAWS | UNLISTED)[name](np.random.default_rng(k), moving.typical) for k in range(20)]
    assert len({law.form for law in laws}) >= 2 or name in UNLISTED
    for form, law in {law.form: law for law in laws}.items():
        variants = variant_set(robot, trials, [law], 2)
        variants.sizes[0][:] = [[0.0], [law.largest]]
        motion = simulate(robot, trials, [law], variants)
        np.testing.assert_array_equal(
            (motion.x + motion.theta)[:, 0], (plain.x + plain.theta)[:, 0]
        )
        assert ("depth" in law.hooks, "shift" in law.hooks) == (
            motion.depth.any(), motion.shift_x.any())  # fmt: skip
        pairs = [part.swapaxes(0, 1) for part in (motion.x, motion.theta, motion.shift_x)]
        if law.seen:
            look, track = with_laws(view, [law], [law.largest]), Track(motion, 1)
            pairs += [(moving.seen[j], observe(look, track, TIMES, j)) for j in (2, 3)]
            unchanged = observe(with_laws(view, [law], [0.0]), Track(motion), TIMES, 3)
            np.testing.assert_array_equal(unchanged, moving.seen[3])
        if name == "wake_reentry":
            here = Here(robot, trials, [law], variants)
            here.theta_start = here.theta_start - 6.0  # nearly a whole turn ago
            pairs += [slopes(here, np.moveaxis(variants.start, 2, 0), 0.0).swapaxes(0, 1)]
        assert all(np.isfinite(part).all() for pair in pairs for part in pair), form
        assert max(np.abs(changed - base).max() for base, changed in pairs) > 1e-6, form


@pytest.mark.parametrize("model", ["pinhole", "fisheye"])
def test_labels_projected_by_another_function_come_back_to_the_motion(case, model):
    """A point at the depth, its bent ray found by bisection of Snell's law, and cv2's lenses."""
    view, track, time = view_of(case, model), Track(case.plain), np.linspace(0, 0.9, 8)
    camera, matrix = view.camera, np.eye(3)
    matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2] = camera.lens.k
    points, depth = skeleton(view, track, time, 1)
    pixels = view.pixels(points["head_tip"], depth, time, 1)
    rays = []
    for point, down in zip(points["head_tip"], depth, strict=True):
        away = np.array([point.real, point.imag]) - camera.position[:2]
        far, height, low, high = np.hypot(*away), camera.position[2], 0.0, 1.0
        for _ in range(60):
            at = (low + high) / 2 * far
            bent = at / np.hypot(at, height) > 1.333 * (far - at) / np.hypot(far - at, down)
            low, high = (low, at / far) if bent else (at / far, high)
        rays.append([*(away * low), -height])
    rays = (np.array(rays) @ pose_matrix(camera.rotation_vector).T)[:, None]
    project = cv2.fisheye.projectPoints if model == "fisheye" else cv2.projectPoints
    expected = project(rays, np.zeros(3), np.zeros(3), matrix, np.array(camera.lens.dist))[0]
    np.testing.assert_allclose(expected.reshape(-1, 2), pixels, atol=1e-4)
    np.testing.assert_allclose(view.back(pixels), points["head_tip"], atol=2e-4)
    truth = [track.at(name, time, 1) for name in ("x", "y", "theta", "phi")]
    np.testing.assert_allclose(observe(view, track, time, 1)[:, :4].T, truth, atol=2e-3)


def test_mix_of_a_block():
    drawn = [group_and_fin(7, index) for index in range(20, 40)]
    assert Counter(d[0] for d in drawn) == {"null": 4, "one": 8, "two": 5, "unlisted": 3}
    fins = Counter(d[0] for d in drawn if d[1])
    assert [fins[g] // k for g, k in (("null", 2), ("one", 4), ("two", 2))] == [1, 1, 1]
    assert fins["unlisted"] in (1, 2)
    names = [draw_names(np.random.default_rng(0), 7, CAUSES[g], used, 0) for g, _, used in drawn]
    assert [len(set(n)) for n in names] == [CAUSES[group] for group, _, _ in drawn]


def test_same_seed_gives_same_files_and_an_empty_truth(monkeypatch, tmp_path):
    """The detector is left out: without fin and causes it changes nothing and takes long."""
    monkeypatch.setattr(study, "Whitener", lambda *_: SimpleNamespace(spread=np.zeros(1)))
    monkeypatch.setattr(study, "sigmas", lambda *_: [])
    monkeypatch.setattr(engine, "DT", 0.05)
    truths = [generate(13, 6, tmp_path / part) for part in ("a", "b")]
    files = [sorted(p for p in (tmp_path / part).rglob("*") if p.is_file()) for part in ("a", "b")]
    assert truths[0]["trials"] + 3 == len(files[0])
    assert [p.read_bytes() for p in files[0]] == [p.read_bytes() for p in files[1]]
    assert truths[0]["causes"] == []


@pytest.mark.long
def test_files_pass_check(tmp_path):
    made = tmp_path / "studies" / generate(13, 6, tmp_path)["study"]
    found = CliRunner().invoke(bluekoi, ["check", str(made)])
    assert found.exit_code == 0, found.output
