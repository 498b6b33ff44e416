"""Tests of the kirchhoff study generator."""

import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from validation.generators.kirchhoff import camera as optics
from validation.generators.kirchhoff import effects, noise, observe, studies
from validation.generators.kirchhoff.detector import (
    advance_block,
    block_jacobians,
    cut_into_blocks,
    reshape_by_block,
    tracking_variances,
    whitened_innovations,
)
from validation.generators.kirchhoff.dynamics import (
    HiddenEffect,
    StudyWorld,
    Trials,
    mass_matrix,
    midpoint_step,
    rates,
    simulate,
    straight_growth_rate,
    velocities,
)

default_rng = np.random.default_rng


def make_trials(phi_deg, f=5.0, seconds=6.0):
    phi = np.radians(np.atleast_1d(np.asarray(phi_deg, float)))
    one = np.ones(len(phi))
    return Trials(75 * one, phi, 0 * one, 0.12 * one, f * one, seconds * one, one, one, 0 * one)


def make_world(*hidden):
    return StudyWorld(studies.draw_robot(default_rng(5)), (2.6, 1.6), hidden)


def hidden_effect(name, form, strength, **constants):
    row = next(f for f in effects.FORMS if (f.name, f.form) == (name, form))
    return HiddenEffect(row, strength, row.draw(default_rng(0)) | constants)


NO_GUSTS = np.zeros((800, 3, 1))


def test_terminal_speed_by_hand():
    world = make_world()
    path = simulate(world, make_trials(0, seconds=12), NO_GUSTS, 40)
    speed = np.hypot(*path[-1, 3:5, 0]) / world.robot.mass
    assert speed == pytest.approx(5.0 * np.sqrt(world.robot.C_T / world.robot.C_D0), rel=1e-3)


@pytest.mark.parametrize("phi", [30, -30])
def test_positive_head_angle_turns_clockwise(phi):
    path = simulate(make_world(), make_trials(phi), NO_GUSTS, 40)
    assert np.sign(path[-1, 2, 0]) == -np.sign(phi)


def test_port_and_starboard_mirror():
    path = simulate(make_world(), make_trials([25, -25]), np.zeros((800, 3, 2)), 40)
    assert path[:, 2, 0] == pytest.approx(-path[:, 2, 1], abs=1e-9)


def test_midpoint_is_of_second_order():
    world, trials = make_world(), make_trials(30, seconds=3)
    ends = [simulate(world, trials, NO_GUSTS, n)[3 * n, :3, 0] for n in (40, 80, 640)]
    coarse, fine = (np.linalg.norm(e - ends[2]) for e in ends[:2])
    assert 3 < coarse / fine < 5.5


@pytest.mark.parametrize("form", ["spheroid", "strip", "head_plate"])
def test_added_mass_conserves_energy_without_forces(form):
    world = make_world(hidden_effect("added_mass", form, 1.0))
    none = dict.fromkeys(("C_T", "C_La", "C_D0", "C_Da", "C_Ma", "C_Md"), 0.0)
    world = replace(world, robot=replace(world.robot, **none))
    trials = make_trials(20)
    y = np.zeros((8, 1))
    y[3:6, 0] = 0.2, 0.1, 0.004
    energies = []
    for _ in range(400):
        _, nu, _, phi = velocities(world, trials, np.zeros(1), y)
        energies.append(float(nu[0] @ mass_matrix(world, phi)[0][0] @ nu[0]) / 2)
        y = midpoint_step(world, trials, np.zeros(1), y, 0.005, 0.0)
    assert y[3:5, 0] == pytest.approx([0.2, 0.1])
    assert energies[-1] == pytest.approx(energies[0], rel=1e-3)


@pytest.mark.parametrize(
    "name",
    ["viscous_drag", "wave_drag", "coulomb_friction", "linear_yaw_damping", "crossflow_drag"],
)
def test_dissipative_effects_take_power(name):
    rng, n = default_rng(1), 200
    for form in effects.forms_of(name):
        world = make_world(HiddenEffect(form, 1.0, form.draw(rng)))
        trials = make_trials(rng.uniform(-40, 40, n))
        y = np.zeros((8, n))
        y[2:6] = rng.uniform(-1, 1, (4, n)) * np.array([[3], [0.3], [0.3], [0.01]])
        if form.form == "strips" and name == "linear_yaw_damping":
            continue  # coupled to sway: positive only as a whole
        change = rates(world, trials, np.zeros(n), y) - rates(make_world(), trials, np.zeros(n), y)
        r, m = world.robot.inertia, world.robot.mass
        power = change[3] * y[3] / m + change[4] * y[4] / m + change[5] * y[5] / r
        assert (power <= 1e-12).all(), form.form


def test_finless_robot_is_unstable_and_a_fin_stabilises():
    world = make_world()
    assert straight_growth_rate(world, 5.8) > 1
    fin = studies.draw_fin(default_rng(3), world, 5.8)
    assert straight_growth_rate(replace(world, hidden=(fin,)), 5.8) < -0.09


@pytest.mark.parametrize("seed", range(6))
def test_projection_round_trip(seed):
    rng = default_rng(seed)
    camera = optics.draw_camera(rng, (2.6, 1.6), plain=False)
    place = rng.uniform([0, 0], [2.6, 1.6], (60, 2))
    pixels = optics.project(camera, place, 0.05, 1.333)
    assert optics.pixels_to_pool(camera, pixels, 0.05, 1.333) == pytest.approx(place, abs=1e-7)
    assert (pixels > 0).all()
    assert (pixels < np.array(camera.size)).all()


def test_snell_at_the_surface():
    camera = optics.draw_camera(default_rng(2), (2.6, 1.6), plain=False)
    place = np.array([[0.3, 0.2]])
    s = optics.surface_crossing(camera, place, np.array([0.2]), 1.333)[0]
    out, below = np.hypot(*(s - camera.centre[:2])), np.hypot(*(place[0] - s))
    sines = out / np.hypot(out, camera.centre[2]), below / np.hypot(below, 0.2)
    assert sines[0] == pytest.approx(1.333 * sines[1], rel=1e-9)


def test_matern_has_unit_variance_and_its_integral_time():
    x = noise.matern_process(default_rng(0), 4000, 0.02, 0.2, (40,))
    assert x.std() == pytest.approx(1, rel=0.05)
    lag = np.mean(x[5:] * x[:-5])
    assert lag == pytest.approx((1 + 1) * np.exp(-1), abs=0.04)


def test_composition_of_forty():
    slots = [studies.study_slot(i) for i in range(7, 47)]
    groups = Counter(group for group, _, _ in slots)
    assert groups == {"null": 8, "clear": 8, "faint": 6, "pair": 6, "measurement": 6, "unlisted": 6}
    fins = Counter(group for group, fin, _ in slots if fin)
    assert all(2 * fins[g] == n for g, n in groups.items())
    assert sum(count == 9 for _, _, count in slots) == 10


def test_every_cause_is_dealt():
    dealt = Counter(name for i in range(400) for name in studies.causes_of(9, i))
    assert set(dealt) == set(effects.cause_names("physics")) | set(
        effects.cause_names("measurement")
    )
    physics = [dealt[name] for name in effects.cause_names("physics")]
    assert max(physics) - min(physics) <= 3


def test_every_cause_has_two_forms():
    assert all(len(effects.forms_of(f.name)) >= 2 for f in effects.FORMS)


def test_detector_against_brute_force():
    """Full covariance of open-loop paths against the filter, for a current on stable trials."""
    fin = hidden_effect("tail_fin_lift", "slender", 0.02, arm_m=0.2)
    world = make_world(fin, hidden_effect("uniform_current", "steady", 0.004, toward=0.6))
    trials = make_trials([15, -25], seconds=2.4)
    levels = noise.draw_noise(default_rng(1))
    levels = replace(levels, gust_m_s2=0.004, gust_rad_s2=0.03, gust_tau_s=0.5, matern_tau_s=0.1)
    start = simulate(world, trials, np.zeros((800, 3, 2)), 120)
    path = cut_into_blocks(start, trials, 120)
    F, G = block_jacobians(world, path)
    off = world.with_strength(1, 0)
    push = reshape_by_block(
        advance_block(world, path, path.y) - advance_block(off, path, path.y), path
    )
    columns = np.concatenate([push, np.zeros((*push.shape[:2], 3))], -1)[..., None]
    white, correlated = tracking_variances(world, levels, 1e-3, 30)
    gust = np.array([0.004, 0.004, 0.03])
    w = whitened_innovations(path, F, G, columns, (white, correlated, gust, 0.5, 0.1))
    B = path.count
    total, rng, H = 0.0, default_rng(4), 6000
    rho = np.exp(-0.1 / np.array([0.5, 0.1]))
    for b in range(B):
        n = int(path.seen[:, b].sum())
        x = rng.normal(size=(H, 6)) * np.sqrt([0.01, 0.01, 0.01, 6e-4, 6e-4, 1e-6])
        a, e = rng.normal(size=(2, H, 3))
        mean, seen, signal = np.zeros(6), [], []
        for k in range(n):
            error = np.sqrt(correlated) * e + np.sqrt(white) * rng.normal(size=(H, 3))
            seen.append(x[:, :3] + error)
            signal.append(mean[:3])
            x = x @ F[k, b].T + (a * gust) @ G[k, b].T
            mean = F[k, b] @ mean + push[k, b]
            a = rho[0] * a + np.sqrt(1 - rho[0] ** 2) * rng.normal(size=a.shape)
            e = rho[1] * e + np.sqrt(1 - rho[1] ** 2) * rng.normal(size=e.shape)
        cov, s = np.cov(np.concatenate(seen, 1).T), np.concatenate(signal)
        total += s @ np.linalg.solve(cov, s)
    assert np.sqrt(total) == pytest.approx(np.linalg.norm(w), rel=0.15)


@pytest.fixture(scope="module")
def written_study(tmp_path_factory):
    index = next(i for i in range(40) if studies.study_slot(i) == ("null", True, 9))
    where = [tmp_path_factory.mktemp("tank") for _ in range(2)]
    return index, where, [studies.generate(11, index, folder) for folder in where]


def test_a_study_depends_on_seed_and_index_alone(written_study):
    _, where, truths = written_study
    assert truths[0] == truths[1]
    first, second = (sorted(p for p in w.rglob("*") if p.is_file()) for w in where)
    assert [p.read_bytes() for p in first] == [p.read_bytes() for p in second]


def test_truth_schema(written_study):
    index, where, (truth, _) = written_study
    assert truth["study"] == f"kirchhoff-11-{index:03d}"
    assert (truth["group"], truth["fin"], truth["trials"]) == ("null", True, 9)
    assert truth["verdict"] == "physics"
    assert [c["name"] for c in truth["causes"]] == ["tail_fin_lift"]
    assert truth["causes"][0]["sigma"] >= 15
    folder = where[0] / "studies" / truth["study"]
    assert not list(folder.rglob("*.json"))
    assert len(pd.read_csv(folder / "trials.csv")) == 9


def test_keypoints_give_the_simulated_positions_back(written_study):
    """The camera stated in study.yaml puts the labels on the simulated path within the noise."""
    index, where, (truth, _) = written_study
    _, (study, path, *_) = studies.build_study(11, index)
    folder = where[0] / "studies" / truth["study"]
    document = yaml.safe_load((folder / "study.yaml").read_text())
    table = pd.read_csv(folder / "keypoints" / "T01.csv", header=None, low_memory=False)
    rows = table.iloc[3 if table.iloc[2, 0] == "coords" else 4 :]
    pixels = rows.iloc[:, 7:9].to_numpy(float)
    marks = optics.pool_corners((2.6, 1.6), study.corner_height)
    camera = optics.with_fitted_pose(
        study.camera, marks, np.array(document["camera"]["pool_corners_px"])
    )
    found = optics.pixels_to_pool(camera, pixels, study.world.robot.depth, 1.333)
    k = np.round(np.arange(len(found)) / study.fps * studies.FINE).astype(int)
    error = found - path[k, :2, 0]
    assert np.nanmedian(np.abs(error)) < 0.005
    assert observe.KEYPOINT_NAMES[2] == "core_center"
