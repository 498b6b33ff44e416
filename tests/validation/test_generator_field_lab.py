"""The tank of the untidy field laboratory: dynamics, camera, detector, files."""

import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from validation.generators.field_lab import camera as cam
from validation.generators.field_lab import detector, plan, solve, studies
from validation.generators.field_lab import dynamics as dyn
from validation.generators.field_lab import effects as eff
from validation.generators.field_lab import world as wd

BODY = dyn.BodyParameters(0.68, 0.0095, 0.12, 0.069, 0.07725, 0.04, 0.211, 0.066, 0.12, 2.6, 1.6)
C = dyn.Coefficients(4.5e-3, 0.5, 2.5, 3.14, 0.1, 0.12)


def simulate(seconds, f=5.82, phi=0.0, effects=(), start=None, c=C):
    n = round(1000 * seconds)
    k, p = eff.effect_table(effects)
    start = np.zeros(8) if start is None else np.asarray(start, float)
    still = np.zeros(n + 1, complex)
    return dyn.simulate(BODY, c, start, np.full(n + 1, f), np.full(n + 1, phi), still, 0.0, k, p)


def make_small_study(effects, trials=2):
    rng = np.random.default_rng(5)
    world, _ = plan.draw_study(rng, plan.StudySlot("clear", 0, False, 9), ())
    world = wd.replace(world, trials=world.trials[:trials], effects=effects)
    return wd.replace(
        world, trials=tuple(plan.with_start_pose(rng, world, t) for t in world.trials)
    )


def draw_form(name, code=1):
    return eff.draw_effect(
        np.random.default_rng(1), name, (eff.FORMS | eff.MEASUREMENT)[name][code - 1]
    )


def test_terminal_speed_and_start_match_the_closed_form():
    """v = v_inf tanh(t/tau) for thrust against quadratic drag; v_inf = f sqrt(C_T/C_D0) = 0.552."""
    A, v_inf = 0.12 * 0.069, 5.82 * math.sqrt(4.5e-3 / 0.5)
    tau = 0.68 / (0.5 * 1000 * A * 0.5 * v_inf)
    s = simulate(3.0)
    np.testing.assert_allclose(s[1000::1000, 3], v_inf * np.tanh(np.arange(1, 4) / tau), atol=2e-5)


def test_positive_head_angle_turns_clockwise_and_mirrors():
    left, right = simulate(4, phi=0.5), simulate(4, phi=-0.5)
    assert left[-1, 5] < -0.1
    np.testing.assert_allclose(left[:, [1, 2]], -right[:, [1, 2]], atol=1e-12)


def test_radius_does_not_depend_on_power_in_the_base_model():
    radius = [
        np.hypot(*s[-1, 3:5]) / -s[-1, 5] for s in (simulate(12, 2.4, 0.5), simulate(12, 5.8, 0.5))
    ]
    assert radius[0] == pytest.approx(radius[1], rel=1e-3)


def test_straight_swimming_is_unstable_without_a_fin():
    """docs/paper.md, Straight swimming: growth of 3.6 per second at 100 %."""
    k, p = eff.effect_table(())
    assert dyn.straight_growth_rate_per_s(BODY, C, 5.82, k, p) == pytest.approx(3.6, abs=0.2)


def test_added_mass_keeps_kinetic_energy_of_an_ideal_body():
    """Without thrust and forces of the head plate the Kirchhoff equations conserve energy."""
    free = dyn.Coefficients(*[1e-12] * 6)
    e = wd.replace(draw_form("added_mass"), strength=0.5)
    s = simulate(3, 0.0, 0.0, (e,), (0, 0, 0.3, 0.4, 0.1, 0.8, 0, 0), free)
    v = (s[:, 3] + 1j * s[:, 4]) * np.exp(-1j * s[:, 2])
    T = 0.74 * v.real**2 + 1.18 * v.imag**2 + (0.0095 + 0.003) * s[:, 5] ** 2
    assert np.ptp(T) < 2e-3 * T[0]


@pytest.mark.parametrize(
    "name",
    ["viscous_drag", "wave_drag", "coulomb_friction", "linear_yaw_damping", "crossflow_drag"],
)
def test_dissipative_effects_give_no_power(name):
    for form in eff.FORMS[name]:
        e = eff.draw_effect(np.random.default_rng(2), name, form)
        k, p = eff.effect_table((e,))
        for u, s, r in ((0.3, 0.05, 0.5), (0.1, -0.2, -0.7), (0.5, 0.0, 0.1)):
            F, N = dyn.core_loads(BODY, 0.0, u, s, r, 3.0, 0.2, k, p)
            assert F.real * u + F.imag * s + N * r < 0, form.name


@pytest.mark.parametrize("seed", range(4))
def test_projection_round_trip_through_the_surface(seed):
    rng = np.random.default_rng(seed)
    c = cam.draw_camera(rng, True)
    xy = rng.uniform((0.1, 0.1), (2.5, 1.5), (40, 2))
    px = cam.project_water(c, xy, np.full(40, 0.06), 1.333)
    np.testing.assert_allclose(cam.pixels_to_pool(c, px, 0.06, 1.333), xy, atol=1e-8)
    assert (px > 0).all()
    assert (px < [1920, 1080]).all()


def test_stated_laboratory_reads_the_simulated_positions_back():
    world = make_small_study(())
    dy, _ = detector.observation_changes(world, 0, wd.trial_path(world, world.trials[0]))
    assert np.abs(dy[:, :3]).max() < 1e-6
    np.testing.assert_allclose(dy[:, 3], 0.0, atol=1e-6)


def test_whitening_equals_the_joint_covariance():
    """Brute force: joint covariance of all observations of a trial, no recursion."""
    world = make_small_study((wd.replace(draw_form("linear_yaw_damping"), strength=0.004),), 1)
    trial = world.trials[0]
    F, g = detector.linearise_blocks(world, trial, wd.trial_path(world, trial))
    F, g = F[:8], g[:8]
    Q, R, P = detector.noise_model(world, trial)
    dy = np.zeros((len(F), 4, g.shape[2]))
    fast = detector.whitened_innovations(F, g, dy, (Q, R, P))[:, 0]
    n, z = len(F), np.zeros(15)
    rows, mean = np.zeros((4 * n, 15 * (n + 1))), []
    T = np.zeros((15, 15 * (n + 1)))
    T[:, :15] = np.linalg.cholesky(P)
    for j in range(n):
        T = F[j] @ T
        T[:, 15 * (j + 1) : 15 * (j + 2)] += np.sqrt(Q)
        z = F[j] @ z + g[j][:, 0]
        rows[4 * j : 4 * j + 4] = detector.OBSERVATION_MATRIX @ T
        mean.append(detector.OBSERVATION_MATRIX @ z)
    S = rows @ rows.T + np.kron(np.eye(n), R)
    d = np.concatenate(mean)
    assert fast @ fast == pytest.approx(d @ np.linalg.solve(S, d), rel=1e-6)


def test_composition_of_forty_studies():
    slots = [plan.study_slot(i) for i in range(7, 47)]
    for group, size in plan.GROUP_COUNTS:
        mine = [s for s in slots if s.group == group]
        assert len(mine) == size
        assert sum(s.fin for s in mine) == size // 2
    assert sum(s.trials == 9 for s in slots) == 10


def test_every_cause_is_dealt_about_equally_often():
    heads = [
        plan.causes_from_deck(3, i)[: 2 if plan.study_slot(i).group == "pair" else 1]
        for i in range(280)
    ]
    flat = [n for h in heads for n in h]
    count = {n: flat.count(n) for n in (*plan.PHYSICS, *eff.MEASUREMENT)}
    assert max(count.values()) - min(count.values()) <= 3


def test_a_study_is_whole_consistent_and_deterministic(tmp_path):
    index = next(
        i for i in range(40) if plan.study_slot(i)[::3] == ("null", 9) and plan.study_slot(i).fin
    )
    reported = studies.generate(11, index, tmp_path / "a")
    studies.generate(11, index, tmp_path / "b")
    files = sorted(
        p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*.*") if p.is_file()
    )
    assert all(
        (tmp_path / "a" / f).read_bytes() == (tmp_path / "b" / f).read_bytes() for f in files
    )
    assert reported["verdict"] == "physics"
    assert [c["name"] for c in reported["causes"]] == ["tail_fin_lift"]
    assert reported["causes"][0]["sigma"] >= 15
    assert reported == json.loads(
        (tmp_path / "a" / "truth" / f"{reported['study']}.json").read_text()
    )


def test_strength_bounds_are_ordered_and_forms_are_several():
    for name, forms in (eff.FORMS | eff.MEASUREMENT).items():
        assert len(forms) >= 2, name
        assert all(f.strength[2] < f.strength[3] for f in forms), name
        assert solve.first_strength(eff.draw_effect(np.random.default_rng(0), name, forms[0])) != 0
