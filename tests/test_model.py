"""The two-plate model against the paper, its audit, and an integration written independently."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bluekoi.integrate.stage_dependencies import stage_arguments
from bluekoi.model import (
    PUBLISHED_FLAP_HZ,
    TABLE_1,
    constants_of_robot_trial,
    simulate,
    steady_speed_and_radius,
    two_plate_system,
)
from bluekoi.model.two_plate_model import EQUATION_OF_MOTION_STAGES
from bluekoi.observation import camera_error_constant_names
from bluekoi.tuning import straight_swimming_growth_per_s
from paper_robot import PAPER_SETUP

FIN_PARAMETERS = {"tail_fin_lift": {"lift_area": 0.012, "arm": 0.15}}


def published_rates(t: float, s: np.ndarray, power: int, phi: float) -> list[float]:
    """Eq. 8 with Table I at a power."""
    return published_rates_in_world_axes(t, s, TABLE_1[power], phi, PUBLISHED_FLAP_HZ[power])


def published_rates_in_world_axes(
    t: float, s: np.ndarray, c: Mapping[str, float], phi: float, f: float
) -> list[float]:
    """Eq. 8 in world axes and complex numbers, as printed; A, l of the 1x head."""
    rho, A = 1000.0, 0.12 * 0.069
    l, m, I = 0.12 + 0.04 - 0.331 / 4, 0.68, 0.0095
    theta, v, r = s[2], complex(s[3], s[4]), s[5]
    speed = abs(v)
    T = c["C_T"] * 0.5 * rho * A * f**2 * cmath.exp(1j * (theta + phi))
    if speed == 0:
        a, M, N = T / m, 0.0, 0.0
    else:
        alpha = theta - cmath.phase(v)
        q = 0.5 * rho * A * speed**2
        L = q * c["C_La"] * math.sin(2 * alpha) * v / speed * 1j
        D = -q * (c["C_D0"] + c["C_Da"] * (1 - math.cos(2 * alpha))) * v / speed
        M = q * c["C_Ma"] * math.sin(2 * alpha) - c["C_Md"] * r * abs(r)
        N = ((L + D) * (1j * cmath.exp(1j * theta)).conjugate()).real
        a = (T + L + D) / m
    if speed == 0:
        M = -c["C_Md"] * r * abs(r)
    return [s[3], s[4], r, a.real, a.imag, (M + N * l) / I]


@pytest.mark.parametrize("power", [50, 75, 100])
def test_compiled_model_follows_the_printed_equations(power: int) -> None:
    phi = math.radians(45)
    run = simulate(
        TABLE_1[power],
        setup=PAPER_SETUP,
        head_length_m=0.12,
        head_angle_rad=phi,
        flap_hz=PUBLISHED_FLAP_HZ[power],
        duration_s=8.0,
    )
    exact = solve_ivp(published_rates, (0, 8), [0, 0, -phi, 0, 0, 0], args=(power, phi),
                      method="DOP853", rtol=1e-10, atol=1e-12, t_eval=[8.0])  # fmt: skip
    assert np.abs(run.state[-1, :2] - exact.y[:2, 0]).max() < 1e-4
    assert abs(run.state[-1, 2] - exact.y[2, 0]) < math.radians(0.05)


def test_order_of_convergence_is_four() -> None:
    def end(dt: float) -> np.ndarray:
        return simulate(
            TABLE_1[75],
            setup=PAPER_SETUP,
            head_length_m=0.12,
            head_angle_rad=0.6,
            flap_hz=4.02,
            duration_s=4.0,
            dt_s=dt,
            start=(0, 0, 0, 0.1, 0, 0),
        ).state[-1]

    fine = end(1 / 960)
    errors = [np.abs(end(1 / n) - fine).max() for n in (60, 120)]
    assert 3.5 < math.log2(errors[0] / errors[1]) < 5.0


def test_audit_1_terminal_speeds_in_the_unit_reading() -> None:
    speeds = [
        steady_speed_and_radius(
            TABLE_1[p],
            setup=PAPER_SETUP,
            head_length_m=0.12,
            head_angle_rad=0.0,
            flap_hz=PUBLISHED_FLAP_HZ[p],
        )[0]
        for p in (50, 75, 100)
    ]
    assert speeds == pytest.approx([0.225, 0.381, 0.552], abs=0.001)


def test_audit_1_as_printed_the_speed_would_be_17_5_m_s() -> None:
    assert 5.82 * math.sqrt(4.5 / 0.5) == pytest.approx(17.5, abs=0.05)
    printed = TABLE_1[100] | {"C_T": 4.5}
    speed, _ = steady_speed_and_radius(
        printed, setup=PAPER_SETUP, head_length_m=0.12, head_angle_rad=0.0, flap_hz=5.82
    )
    assert speed == pytest.approx(17.46, abs=0.1)


def test_audit_3_one_coefficient_set_makes_the_radius_independent_of_power() -> None:
    radii = [
        steady_speed_and_radius(
            TABLE_1[75],
            setup=PAPER_SETUP,
            head_length_m=0.12,
            head_angle_rad=math.radians(45),
            flap_hz=f,
        )[1]
        for f in PUBLISHED_FLAP_HZ.values()
    ]
    assert np.ptp(radii) / np.mean(radii) < 1e-3
    assert 0.36 < np.mean(radii) < 1.0


def test_audit_5_straight_swimming_is_unstable_and_a_fin_steadies_it() -> None:
    growth = {
        p: straight_swimming_growth_per_s(
            TABLE_1[p], setup=PAPER_SETUP, flap_hz=PUBLISHED_FLAP_HZ[p]
        )
        for p in (50, 100)
    }
    assert growth[100] == pytest.approx(3.6, abs=0.2)
    assert growth[50] == pytest.approx(1.5, abs=0.1)
    assert (
        straight_swimming_growth_per_s(
            TABLE_1[100], setup=PAPER_SETUP, flap_hz=5.82, effects=FIN_PARAMETERS
        )
        < 0
    )


def test_turns_mirror() -> None:
    runs = [
        simulate(
            TABLE_1[75],
            setup=PAPER_SETUP,
            head_length_m=0.12,
            head_angle_rad=s * 0.5,
            flap_hz=4.0,
            duration_s=4.0,
            effects=FIN_PARAMETERS,
        )
        for s in (1, -1)
    ]
    assert runs[0].state[:, 0] == pytest.approx(runs[1].state[:, 0], abs=1e-9)
    assert runs[0].state[:, 1] == pytest.approx(-runs[1].state[:, 1], abs=1e-9)
    assert runs[0].state[-1, 5] < 0


def test_straight_head_swims_exactly_straight() -> None:
    run = simulate(
        TABLE_1[100],
        setup=PAPER_SETUP,
        head_length_m=0.12,
        head_angle_rad=0.0,
        flap_hz=5.82,
        duration_s=8.0,
    )
    assert np.all(run.state[:, 1] == 0)


def test_longer_head_has_the_contract_s_arm() -> None:
    values = constants_of_robot_trial(PAPER_SETUP, 0.175)
    assert values[3] == pytest.approx(0.175 + 0.04 - (0.331 + 0.055) / 4)
    assert values[1] == pytest.approx(0.175 * 0.069)


def test_no_equation_of_motion_depends_on_how_the_robot_is_seen() -> None:
    physics = [e for e in two_plate_system().effects if e.kind != "measurement"]
    asked = {
        name for stage in EQUATION_OF_MOTION_STAGES for name in stage_arguments(stage, physics)
    }
    assert not asked & set(camera_error_constant_names())


def test_a_swim_is_simulated_without_a_camera() -> None:
    tank = SimpleNamespace(robot=PAPER_SETUP.robot, pool=PAPER_SETUP.pool, water=PAPER_SETUP.water)
    with_camera, without = (
        simulate(TABLE_1[75], setup=setup, head_length_m=0.12, head_angle_rad=0.5,
                 flap_hz=4.0, duration_s=2.0) for setup in (PAPER_SETUP, tank)
    )  # fmt: skip
    assert np.array_equal(with_camera.state, without.state)
