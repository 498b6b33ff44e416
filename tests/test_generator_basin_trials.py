"""The generator of basin trials: its mechanics, its laws, its camera and its files."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from study_files import assert_same_files

from bluekoi.cli import main
from validation.generators.basin_trials import generate
from validation.generators.basin_trials.camera import Camera
from validation.generators.basin_trials.catalogue import FAMILIES
from validation.generators.basin_trials.form import HiddenLaw, Runs
from validation.generators.basin_trials.motion import integrate, rates
from validation.generators.basin_trials.robots import Robot, draw_fin, straight_growth

TABLE_I = {"C_T": 4.5e-3, "C_La": 3.14, "C_Da": 4.0, "C_D0": 0.5, "C_Ma": 0.1, "C_Md": 0.104}
PAPER_ROBOT = Robot(0.68, 0.0095, 0.331, 0.12, 0.069, 0.04, 0.066, 0.04, TABLE_I)
SEED, NULL_WITH_FIN, TIME_OFFSET = 8, 12, 15  # studies of nine trials
PASSIVE = ("viscous_drag", "wave_drag", "coulomb_friction", "linear_yaw_damping", "crossflow_drag")
TIED = ("uniform_current", "compass", "hunting")  # to the pool or the clock
EVEN = [name for name, f in FAMILIES.items() if not f.signed and name not in TIED]


def runs_of(degrees, robot=PAPER_ROBOT, hertz=5.82, **coefficients):
    n, values = len(degrees), {**robot.coefficients, **coefficients}
    if robot.fin:
        values |= {"fin_area": robot.fin.area, "fin_arm": robot.fin.arm}
    return Runs(np.radians(degrees), np.full(n, 0.12), np.full(n, hertz), np.arange(n), np.zeros(n),
                {k: np.full(n, v) for k, v in values.items()})  # fmt: skip


def random_states(n):
    size = np.array([0.3, 0.2, 1, 0.3, 0.2, 1, 0.1, 9])[:, None]
    middle = np.array([1.3, 0.8, 0, 0, 0, 0, 0, 0])[:, None]
    return middle + size * np.random.default_rng(4).normal(size=(8, n))


def laws_of(name):
    family = FAMILIES[name]
    return [HiddenLaw(family, form, (0.3, 0.6, 0.4), family.start) for form in family.forms]


def published_forces(theta, phi, v, rate, f):
    """T + L + D (complex, pool frame) and M + N l of MODEL.md, Eqs. 1 to 8."""
    k, A, arm = TABLE_I, 0.12 * 0.069, 0.12 + 0.04 - 0.331 / 4
    alpha, q = np.angle(np.exp(1j * theta) / v), 500 * A * np.abs(v) ** 2
    L = q * k["C_La"] * np.sin(2 * alpha) * v / np.abs(v) * 1j
    D = -q * (k["C_D0"] + k["C_Da"] * (1 - np.cos(2 * alpha))) * v / np.abs(v)
    N = np.real((L + D) * np.conj(1j * np.exp(1j * theta)))
    moment = q * k["C_Ma"] * np.sin(2 * alpha) - k["C_Md"] * rate * np.abs(rate) + N * arm
    return k["C_T"] * 500 * A * f**2 * np.exp(1j * (theta + phi)) + L + D, moment


def test_steady_turns_balance_the_published_forces_and_their_radius_is_that_of_any_power():
    radii = []
    for hertz, count in ((5.82, 300), (2.91, 600)):
        runs = runs_of([30.0, -30.0], hertz=hertz)
        end = integrate(np.zeros((8, 2)), runs, PAPER_ROBOT, step=0.02, count=count, every=5)[-1]
        v, r = (end[3] + 1j * end[4]) * np.exp(1j * end[2]), end[5]
        force, moment = published_forces(end[2] - runs.phi, runs.phi, v, r, hertz)
        np.testing.assert_allclose(0.68 * 1j * r * v, force, rtol=1e-3)
        assert np.abs(moment).max() < 1e-3 * (0.104 * r**2).max()
        assert r[0] < 0 < r[1]
        radii += list(np.abs(v / r))
    np.testing.assert_allclose(radii, radii[0], rtol=1e-3)


def test_growth_in_straight_swimming_is_that_of_the_equations_and_a_fin_makes_it_decay():
    assert straight_growth(PAPER_ROBOT, None) == pytest.approx(3.6, abs=0.1)  # MODEL.md, audit 5
    for seed in range(12):
        robot = replace(PAPER_ROBOT, fin=draw_fin(np.random.default_rng(seed), PAPER_ROBOT))
        state = np.zeros((8, 3))
        state[3] = 5.8 * np.sqrt(4.5e-3 / 0.5)
        state[4, 1] = state[5, 2] = step = 1e-7
        change = rates(np.zeros(3), state, runs_of([0.0] * 3, robot, 5.8), robot)[4:6]
        slope = np.linalg.eigvals((change[:, 1:] - change[:, :1]) / step).real.max()
        assert slope < -0.14
        if robot.fin.form != "trailing_edge":  # straight_growth takes it as one point
            assert straight_growth(robot, robot.fin) == pytest.approx(slope, rel=1e-3)


def power_of(law, inertia=(0.68, 0.68, 0.0095)):
    """Kinetic energy gained per second where nothing but this law acts."""
    state, runs = random_states(6), runs_of([0.0] * 6, **dict.fromkeys(TABLE_I, 0.0))
    change = rates(np.ones(6), state, runs, PAPER_ROBOT, laws=[law])
    return np.array(inertia) @ (state[3:6] * change[3:6])


@pytest.mark.parametrize("name", PASSIVE)
def test_passive_forces_take_energy(name):
    for law in laws_of(name):
        assert power_of(law).max() <= 1e-12
        assert power_of(law).min() < -1e-4


def test_added_mass_without_coupling_keeps_the_kinetic_energy():
    law, mass = laws_of("added_mass")[0], 0.3 * 0.68
    inertia = [0.68 + 0.09 * mass, 0.68 + mass, 0.0095 + 0.6 * mass * 0.331**2 / 12]
    np.testing.assert_allclose(power_of(law, inertia), 0, atol=1e-12)


@pytest.mark.parametrize("name", EVEN)
def test_even_laws_are_mirror_symmetric(name):
    flip = np.array([1, -1, -1, 1, -1, -1, -1, -1.0])[:, None]
    state, t = random_states(6), np.linspace(0.1, 2.6, 6)
    runs = replace(runs_of(np.linspace(-40, 40, 6)), head=np.full(6, 0.17))
    mirrored = state * flip + np.array([0, 1.6, 0, 0, 0, 0, 0, 0])[:, None]
    plain = rates(t, state, runs, PAPER_ROBOT)
    for law in laws_of(name):
        found = rates(t, state, runs, PAPER_ROBOT, laws=[law])
        other = rates(t, mirrored, replace(runs, phi=-runs.phi), PAPER_ROBOT, laws=[law])
        np.testing.assert_allclose(other, flip * found, atol=1e-9)
        assert np.abs(found - plain).max() > 1e-4


def test_rays_obey_snell_s_law():
    eye, point = np.array([1.3, 0.8, 2.5]), np.array([2.4, 0.8, -0.2])
    down = Camera("pinhole", (2, 2), (1.0, 1.0), (0.0, 0.0), (0.0,) * 5, eye, np.diag([1, -1, -1]))
    tangent = down.project(point)[0]
    below = (point[0] - eye[0] - 2.5 * tangent) / 0.2
    assert np.sin(np.arctan(tangent)) == pytest.approx(1.333 * np.sin(np.arctan(below)), rel=1e-6)


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("basin_trials")
    return folder, [generate(SEED, index, folder) for index in (NULL_WITH_FIN, TIME_OFFSET)]


def test_studies_are_accepted_and_truths_have_the_keys_of_the_scores(generated):
    folder, truths = generated
    for truth, cause in zip(truths, ("tail_fin_lift", "time_offset"), strict=True):
        done = CliRunner().invoke(main, ["check", str(folder / "studies" / truth["study"])])
        assert "no error found in the files" in done.output, done.output
        written = json.loads((folder / "truth" / f"{truth['study']}.json").read_text())
        assert written == truth
        assert {"generator", "group", "fin", "trials"} <= set(written)
        assert [(c["name"], c["sigma"] > 2) for c in written["causes"]] == [(cause, True)]
        assert len(written["conditions"]["trials"]) == written["trials"] == 9
    assert [(t["group"], t["fin"]) for t in truths] == [("null", True), ("measurement", False)]


def test_a_seed_gives_the_same_files(generated, tmp_path):
    generate(SEED, TIME_OFFSET, tmp_path)
    assert_same_files(tmp_path, generated[0])
