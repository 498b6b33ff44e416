"""The synthetic tank: published numbers, exact motions, symmetry, stability, water."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bluekoi.synthetic.eddies import random_eddies, water_velocity
from bluekoi.synthetic.ground_truth_physics import (
    Fin,
    GroundTruthPhysics,
    TrialSettings,
    aerodynamic_arm,
    published_model_physics,
)
from bluekoi.synthetic.motion_simulation import simulate_true_motion, true_steady_speed_and_radius
from bluekoi.synthetic.synthetic_study_design import SIMULATED_FLAP_HZ_BY_POWER
from small_studies import TABLE_1

PUBLISHED_TANK = published_model_physics(GroundTruthPhysics())
TANK_WITHOUT_RECOIL = GroundTruthPhysics(recoil=None)


def simulated_turn(
    tank: GroundTruthPhysics, power: int, angle_deg: float, head_m: float = 0.12
) -> tuple[float, float]:
    return true_steady_speed_and_radius(
        tank,
        TrialSettings(SIMULATED_FLAP_HZ_BY_POWER[power], math.radians(angle_deg), head_m),
        settle_s=12.0,
    )


@pytest.mark.parametrize(("power", "speed"), [(50, 0.225), (75, 0.381), (100, 0.552)])
def test_paper_terminal_speeds_model_md_audit_1(power: int, speed: float) -> None:
    tank = replace(PUBLISHED_TANK, coefficients=TABLE_1[power])
    assert simulated_turn(tank, power, 0.0)[0] == pytest.approx(speed, abs=6e-4)


def test_straight_start_is_a_tanh() -> None:
    c, robot = PUBLISHED_TANK.coefficients, PUBLISHED_TANK.robot
    area = 0.12 * robot.head_span_m
    top = 5.82 * math.sqrt(c.C_T / c.C_D0)
    lag = robot.mass_kg / (0.5 * 1000 * area * c.C_D0 * top)
    time_s = np.linspace(0, 4, 41)
    state = simulate_true_motion(
        PUBLISHED_TANK, TrialSettings(5.82, 0.0, 0.12), 4.0
    ).state_without_recoil(time_s)
    assert np.allclose(state[:, 3], top * np.tanh(time_s / lag), atol=1e-8)
    assert np.allclose(state[:, 0], top * lag * np.log(np.cosh(time_s / lag)), atol=1e-8)
    assert np.abs(state[:, [1, 2, 4, 5]]).max() < 1e-12


def test_radius_of_the_bare_model_does_not_depend_on_power_model_md_audit_3() -> None:
    radii = [simulated_turn(PUBLISHED_TANK, power, 45.0)[1] for power in SIMULATED_FLAP_HZ_BY_POWER]
    assert np.ptp(radii) / np.mean(radii) < 1e-3


def test_table_1_radii_lie_where_reported_model_md_audit_1() -> None:
    radii = [
        simulated_turn(replace(PUBLISHED_TANK, coefficients=TABLE_1[power]), power, angle, head)[1]
        for power in SIMULATED_FLAP_HZ_BY_POWER
        for angle, head in ((30.0, 0.12), (45.0, 0.12), (45.0, 0.175))
    ]
    assert min(radii) > 0.35
    assert max(radii) < 1.0


def test_positive_head_angle_turns_clockwise_and_sides_mirror() -> None:
    time_s = np.linspace(0, 3, 13)
    left = simulate_true_motion(
        TANK_WITHOUT_RECOIL, TrialSettings(4.0, 0.5, 0.12), 3.0
    ).state_without_recoil(time_s)
    right = simulate_true_motion(
        TANK_WITHOUT_RECOIL, TrialSettings(4.0, -0.5, 0.12), 3.0
    ).state_without_recoil(time_s)
    assert left[-1, 5] < -0.1
    sign = np.array([1, -1, -1, 1, -1, -1])
    start = np.array([0, 0, 0, 0, 0, 0])
    assert np.allclose(left[:, :6] - start, right[:, :6] * sign, atol=1e-7)


def test_bare_model_cannot_swim_straight_but_the_fin_can_model_md_audit_5() -> None:
    time_s = np.linspace(3, 4, 11)
    run = TrialSettings(5.82, 1e-8, 0.12)
    bare = np.abs(simulate_true_motion(PUBLISHED_TANK, run, 4.0).state_without_recoil(time_s)[:, 5])
    growth = np.polyfit(time_s, np.log(bare), 1)[0]
    assert growth == pytest.approx(3.6, abs=0.3)
    assert (
        np.abs(
            simulate_true_motion(TANK_WITHOUT_RECOIL, run, 4.0).state_without_recoil(time_s)[:, 5]
        ).max()
        < 1e-3
    )


def test_default_radii_are_tight_and_independent_of_power() -> None:
    radii = [
        simulated_turn(TANK_WITHOUT_RECOIL, power, 30.0)[1] for power in SIMULATED_FLAP_HZ_BY_POWER
    ]
    assert min(radii) > 0.3
    assert max(radii) < 1.0
    assert np.ptp(radii) < 1e-3


def test_linear_yaw_damping_spreads_the_radii_by_10_to_20_percent() -> None:
    tank = replace(TANK_WITHOUT_RECOIL, yaw_damping_n_m_s=0.03)
    slow, fast = (simulated_turn(tank, power, 30.0)[1] for power in (50, 100))
    assert 1.10 < slow / fast < 1.20


def test_geometry_of_the_aerodynamic_arm() -> None:
    assert aerodynamic_arm(PUBLISHED_TANK.robot, 0.12) == pytest.approx(0.12 + 0.04 - 0.331 / 4)
    assert aerodynamic_arm(PUBLISHED_TANK.robot, 0.175) == pytest.approx(0.215 - 0.386 / 4)


def test_recoil_stays_small_and_starts_from_nothing() -> None:
    motion = simulate_true_motion(
        GroundTruthPhysics(), TrialSettings(5.82, 0.0, 0.12, start_beat_rad=1.0), 2.0
    )
    time_s = np.linspace(0, 2, 801)
    off = motion.pose_with_recoil(time_s)[:, :3] - motion.state_without_recoil(time_s)[:, :3]
    assert np.abs(off[0]).max() == 0
    assert 0.0025 < np.abs(off[:, 1]).max() < 0.0035
    assert 1.2 < np.degrees(np.abs(off[:, 2])).max() < 1.6


def test_eddies_have_the_rms_asked_for_and_no_divergence() -> None:
    rng = np.random.default_rng(5)
    speeds, step = [], 1e-5
    for _ in range(40):
        eddies = random_eddies(rng, 0.002)
        z, t = complex(rng.uniform(0, 2.6), rng.uniform(0, 1.6)), rng.uniform(0, 9)
        speeds.append(abs(water_velocity(eddies, t, z)) ** 2)
        dx = (water_velocity(eddies, t, z + step) - water_velocity(eddies, t, z - step)).real
        dy = (
            water_velocity(eddies, t, z + 1j * step) - water_velocity(eddies, t, z - 1j * step)
        ).imag
        assert abs(dx + dy) / (2 * step) < 1e-9
    assert math.sqrt(np.mean(speeds)) == pytest.approx(0.002, rel=0.3)
    assert random_eddies(rng, 0.0) == ()


def test_fin_takes_power_out_of_a_sideways_drift() -> None:
    strong = replace(TANK_WITHOUT_RECOIL, fin=Fin(area_m2=0.05))
    run = TrialSettings(4.0, 0.4, 0.12)
    assert (
        true_steady_speed_and_radius(strong, run, settle_s=10)[0]
        != true_steady_speed_and_radius(TANK_WITHOUT_RECOIL, run, settle_s=10)[0]
    )
