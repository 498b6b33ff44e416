"""Every effect and measurement cause in the folders, by the same properties."""

from __future__ import annotations

import importlib
import inspect

import numpy as np
import pytest
from candidate_causes import MEASUREMENT, PHYSICS

from bluekoi import effects, measurement
from bluekoi.fitting.side_measurements import predict_side_measurement
from bluekoi.integrate import Effect
from bluekoi.model import (
    TABLE_1,
    constants_of_robot_trial,
    effect_names,
    residual,
    simulate,
    two_plate_system,
)
from bluekoi.model.equations import relative_flow_velocities
from paper_robot import PAPER_SETUP

ONE_SIDED = {
    "head_angle_offset", "trim_moment", "uniform_current", "pool_gyre", "wall_effect",
    "port_starboard_asymmetry", "keypoint_bias", "camera_shift", "scale_error", "lens_error",
    "centre_of_mass_shift",
    "uncorrected_refraction",
}  # fmt: skip
DISSIPATIVE = {
    "viscous_drag", "linear_yaw_damping", "crossflow_drag", "wave_drag", "coulomb_friction",
    "wall_effect", "sinking",
}  # fmt: skip
ALL_EFFECTS = [e for e in two_plate_system().effects if e.kind in ("physics", "measurement")]


def active_at_start_value(effect: Effect) -> dict[str, dict[str, float]]:
    return {effect.name: {p.name: p.start for p in effect.parameters}}


def trial_arguments(means: list[list[float]]) -> np.ndarray:
    """Means of head angle, frequency and time in trials of the published robot, its constants."""
    return np.array([[*row, *constants_of_robot_trial(PAPER_SETUP, 0.12)] for row in means])


def simulated_path(effect: Effect | None, side: float = 1.0, **given: float) -> np.ndarray:
    run = simulate(
        TABLE_1[75],
        setup=PAPER_SETUP,
        head_length_m=0.175,
        head_angle_rad=side * 0.6,
        flap_hz=4.0,
        duration_s=6.0,
        start=(1.3, 0.8, 0.0, 0.0, 0.0, 0.0),
        effects=active_at_start_value(effect) if effect else None,
        **given,
    )
    return run.state


def test_the_folders_hold_every_name_of_the_contract() -> None:
    assert set(effect_names(effects)) >= PHYSICS
    assert set(effect_names(measurement)) >= MEASUREMENT


@pytest.mark.parametrize("effect", ALL_EFFECTS, ids=lambda e: e.name)
def test_statement_units_bounds_and_source(effect: Effect) -> None:
    module = importlib.import_module(effect.module)
    assert effect.statement.endswith(".")
    assert len(effect.statement) > 30
    assert "Source:" in (module.__doc__ or "")
    assert set(effect.confused_with) <= PHYSICS | MEASUREMENT
    for p in effect.parameters:
        assert p.unit
        assert p.meaning
        assert p.lower <= p.start <= p.upper
    assert all(p.lower <= 0 <= p.upper for p in effect.parameters[: effect.strengths])


@pytest.mark.parametrize("effect", [e for e in ALL_EFFECTS if e.forms], ids=lambda e: e.name)
def test_the_95_percent_interval_of_the_prior_holds_every_named_form(effect: Effect) -> None:
    shapes = {p.name: p for p in effect.parameters[effect.strengths :]}
    assert len(effect.forms) >= 2
    for form, values in effect.forms.items():
        assert values.keys() <= shapes.keys(), form
        for name, value in values.items():
            p = shapes[name]
            assert p.lower <= value <= p.upper, (form, name)
            assert abs(value - p.start) <= 2.0 * p.spread + 1e-9, (form, name)


@pytest.mark.parametrize("effect", ALL_EFFECTS, ids=lambda e: e.name)
def test_finite_and_felt(effect: Effect) -> None:
    changed = simulated_path(effect)
    assert np.all(np.isfinite(changed))
    seen_only = "observe" in effect.hooks and len(effect.hooks) == 1
    if effect.name not in ("wake_reentry",) and not seen_only:
        assert np.abs(changed - simulated_path(None)).max() > 1e-5


@pytest.mark.parametrize(
    "effect", [e for e in ALL_EFFECTS if e.name not in ONE_SIDED], ids=lambda e: e.name
)
def test_mirror_symmetry(effect: Effect) -> None:
    left, right = simulated_path(effect, 1.0), simulated_path(effect, -1.0)
    mirrored = right * np.array([1, -1, -1, 1, -1, -1])
    mirrored[:, 1] += 1.6
    assert left == pytest.approx(mirrored, abs=1e-7)


@pytest.mark.parametrize(
    "effect", [e for e in ALL_EFFECTS if e.name in ONE_SIDED], ids=lambda e: e.name
)
def test_one_sided_effects_say_so(effect: Effect) -> None:
    reported = (effect.regime + effect.statement).lower()
    words = ("to one side", "two sides", "position", "wall", "direction", "all frames", "same sign",
             "edges", "opposite sign", "displaced")  # fmt: skip
    assert any(word in reported for word in words)


@pytest.mark.parametrize(
    "effect", [e for e in ALL_EFFECTS if "force" in e.hooks], ids=lambda e: e.name
)
def test_forces_vanish_at_rest(effect: Effect) -> None:
    assert call_effect(effect, "force", np.zeros(0), rest=True) == pytest.approx(
        [0, 0, 0], abs=1e-9
    )


@pytest.mark.parametrize(
    "effect", [e for e in ALL_EFFECTS if e.name in DISSIPATIVE], ids=lambda e: e.name
)
def test_dissipative_forces_never_add_power(effect: Effect) -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        draw = rng.uniform(-1, 1, 3)
        X, Y, N = call_effect(effect, "force", draw)
        assert X * draw[0] + Y * draw[1] + N * draw[2] <= 1e-12


def call_effect(
    effect: Effect, stage: str, draw: np.ndarray, *, rest: bool = False, **given: float
) -> list[float]:
    """The effect's own function at one motion (surge, sway, yaw rate), other values plausible."""
    u, v, r = (0.0, 0.0, 0.0) if rest else draw
    cphi, sphi = np.cos(0.5), np.sin(0.5)
    known = {
        "rho": 1000.0, "A": 0.0083, "A_ref": 0.0083, "span": 0.069, "length": 0.33, "h": 0.12,
        "l": 0.1,
        "x_hinge": 0.04, "x_tail": 0.171, "l_tail": 0.07, "L_pool": 2.6, "W_pool": 1.6,
        "length_unit": 1.0, "speed_unit": 1.0, "time_unit": 1.0,
        "x": 0.1, "y": 0.2,
        "t": 2.0, "psi": 7.0, "psi0": 0.0, "phi0": 0.0, "uc": u, "vc": v, "r": r, "rc": r, "rd": r,
        "V": float(np.hypot(u, v)), "cpsi": 1.0, "spsi": 0.0,
        "uh": u * cphi - v * sphi, "vh": u * sphi + v * cphi, "cphi": cphi, "sphi": sphi,
        "phi": 0.5, "T": 0.0,
        "Xh": -u * abs(u), "Yh": -v * abs(v), "f": 4.0,
        "C_La": 3.0, "C_Ma": 0.1, "C_Md": 0.12, "C_Da": 2.0,
        "C_T": 0.0045, "x_cam": 1.3, "y_cam": 0.8,
    }  # fmt: skip
    known |= {p.argument_name: p.start for p in effect.parameters} | dict.fromkeys(
        effect.states, 0.0
    )
    known |= given
    if "z_fin" in effect.states and "z_fin" not in given:
        known["z_fin"] = v - known["a"] * r  # lift that has built up
    function = effect.rates if stage == "rates" else effect.hooks[stage]
    assert function is not None
    names = inspect.signature(function).parameters
    return list(function(**{name: known[name] for name in names}))


def test_crossflow_drag_of_a_pure_drift_is_the_plate_s() -> None:
    """Reference value: -1/2 rho C d (length) v |v| for a body drifting sideways without turning."""
    X, Y, N = call_effect(
        two_plate_system().effect("crossflow_drag"), "force", np.array([0.0, 0.2, 0.0]), q=0.0
    )
    length, middle = 0.211, (0.04 - 0.171) / 2
    expected = -0.5 * 1000 * 0.5 * 0.069 * length * 0.04
    assert pytest.approx((0.0, expected, expected * middle)) == (X, Y, N)


def test_fin_reference_value() -> None:
    """-1/2 rho S u (v - a r) at u = 0.4, v = 0.1, r = -1: sideways speed 0.25 m/s at the fin."""
    motion = np.array([0.4, 0.1, -1.0])
    X, Y, N = call_effect(two_plate_system().effect("tail_fin_lift"), "force", motion, b=0.0, p=0.0)
    expected = -0.5 * 1000 * 0.03 * 0.4 * 0.25
    assert pytest.approx((0.0, expected, -0.15 * expected)) == (X, Y, N)


def test_fin_of_many_strips_is_one_of_their_mean_and_spread() -> None:
    """Five strips about a = 0.12 m: force and moment of -1/2 rho S u (v - x r) summed."""
    x = 0.12 + 0.03 * np.arange(-2, 3)
    dY = -0.5 * 1000 * 0.03 / 5 * 0.4 * (0.1 + x)
    found = call_effect(
        two_plate_system().effect("tail_fin_lift"),
        "force",
        np.array([0.4, 0.1, -1.0]),
        a=0.12,
        b=float(np.std(x)),
        p=0.0,
    )
    assert found == pytest.approx([0.0, dY.sum(), -(x * dY).sum()])


def test_fin_whose_force_stands_across_the_flow_does_no_work_there() -> None:
    """g = -1: lift alone, at a fin that moves by 0.4 m/s forwards and 0.25 m/s sideways."""
    motion = np.array([0.4, 0.1, -1.0])
    X, Y, _ = call_effect(
        two_plate_system().effect("tail_fin_lift"), "force", motion, b=0.0, p=1.0, g=-1.0
    )
    lift = 0.5 * 1000 * 0.03 * np.hypot(0.4, 0.25) * 0.25
    assert pytest.approx((lift * 0.4 * 0.25 / (0.4**2 + 0.25**2), -lift)) == (X, Y)


def test_vortex_lift_of_a_fin_is_that_of_polhamus_at_small_angles() -> None:
    """K_p sin a cos^2 a + K_v sin^2 a cos a (NASA TN D-3767, 1966), to second order in the angle of
    attack a; q = K_v / K_p = 2.
    """
    V, a = 0.4, 0.05
    motion = np.array([V * np.cos(a), V * np.sin(a), 0.0])
    fin = two_plate_system().effect("tail_fin_lift")
    Y = call_effect(fin, "force", motion, b=0.0, p=0.0, q=2.0, g=0.0)[1]
    polhamus = np.sin(a) * np.cos(a) ** 2 + 2.0 * np.sin(a) ** 2 * np.cos(a)
    assert pytest.approx(-0.5 * 1000 * 0.03 * V**2 * polhamus, rel=0.005) == Y


def test_build_up_of_a_fin_has_a_slope_where_lift_follows_at_once() -> None:
    """Fits end at s = 0; without a slope there, nothing but the prior would act on s."""
    fin, motion = two_plate_system().effect("tail_fin_lift"), np.array([0.4, 0.1, 0.0])
    at = [call_effect(fin, "rates", motion, s=s, z_fin=0.0)[0] for s in (0.0, 0.01)]
    assert at[1] < 0.9 * at[0]


def test_lift_of_a_fin_builds_up_over_its_head_lengths_of_travel() -> None:
    """A fin set to 0.1 m/s sideways at 0.4 m/s, s = 1: z grows as 0.1 (1 - exp(-t / T)), with
    T = h / V + 1/60 s.
    """
    fin = two_plate_system().effect("tail_fin_lift")
    motion, V, z, step = np.array([0.4, 0.1, 0.0]), np.hypot(0.4, 0.1), 0.0, 1e-4
    for _ in range(3000):
        z += step * call_effect(fin, "rates", motion, s=1.0, z_fin=z)[0]
    assert z == pytest.approx(0.1 * (1 - np.exp(-0.3 / (0.12 / V + 1 / 60))), rel=1e-3)
    whole = call_effect(fin, "force", motion, b=0.0, p=0.0)
    part = call_effect(fin, "force", motion, b=0.0, p=0.0, z_fin=z, s=1.0)
    at_once = (1 / 60) / (0.12 / V + 1 / 60)
    assert part[1] == pytest.approx(whole[1] * (z / 0.1 + at_once * (1 - z / 0.1)))


def test_lift_of_a_fin_without_build_up_follows_at_once() -> None:
    """With s = 0 the delay of 1/60 s that the state keeps has no part in the force."""
    fin, motion = two_plate_system().effect("tail_fin_lift"), np.array([0.4, 0.1, 0.5])
    late = call_effect(fin, "force", motion, s=0.0, z_fin=-0.3)
    assert late == pytest.approx(call_effect(fin, "force", motion, s=0.0))


@pytest.mark.parametrize("p", [-0.8, 0.0, 4.0])
@pytest.mark.parametrize("q", [0.0, 4.0])
@pytest.mark.parametrize("g", [-1.0, 0.5, 2.0])
def test_a_fin_of_any_form_never_adds_power(p: float, q: float, g: float) -> None:
    rng = np.random.default_rng(6)
    for draw in rng.uniform(-1, 1, (200, 3)):
        X, Y, N = call_effect(
            two_plate_system().effect("tail_fin_lift"), "force", draw, p=p, q=q, g=g
        )
        assert X * draw[0] + Y * draw[1] + N * draw[2] <= 1e-9


@pytest.mark.parametrize("name", ["viscous_drag", "wave_drag"])
def test_drag_at_the_head_turns_the_robot_by_the_plate_s_arm(name: str) -> None:
    """All of it at the head plate, 0.1 m ahead: moment 0.1 m times the side force."""
    X, Y, N = call_effect(
        two_plate_system().effect(name), "force", np.array([0.3, 0.1, 0.0]), h=1.0
    )
    assert pytest.approx(1 / 3) == Y / X
    assert pytest.approx(0.1 * Y) == N


def test_a_soft_start_is_late_by_half_its_length_as_a_ramp_is() -> None:
    """Missing frequency summed over the start: tau times f, for a ramp and a smooth step."""
    spin_up, t = (
        two_plate_system().effect("motor_spin_up").hooks["actuation_inputs"],
        np.linspace(0, 1.2, 4001),
    )
    for q in (0.0, 0.5, 1.0):
        missing = np.array([spin_up(one, 0.0, 2.0, 1.0, 0.4, 1.0, q, 0.0)[1] for one in t])
        assert missing[0] == pytest.approx(-2.0)
        assert np.trapezoid(missing, t) == pytest.approx(-2.0 * 0.4, rel=1e-6)
        late = np.array([spin_up(one + 0.7, 0.5, 2.0, 1.0, 0.4, 1.0, q, 0.2)[1] for one in t])
        assert late == pytest.approx(missing)  # 0.5 s after the recording, dead for 0.2 s


@pytest.mark.parametrize("missed_s", [0.05, 0.15])
def test_a_video_that_starts_after_the_motor_shows_the_speed_gained_before_it(missed_s) -> None:
    """A run without its first frames, and one from rest with a start delay of minus their time."""
    robot = {"setup": PAPER_SETUP, "head_length_m": 0.12, "head_angle_rad": 0.0, "flap_hz": 4.0,
             "dt_s": 0.005}  # fmt: skip
    whole = simulate(TABLE_1[75], duration_s=4.0 + missed_s, **robot).state
    late = simulate(TABLE_1[75], duration_s=4.0, **robot,
                    effects={"time_offset": {"start_delay": -missed_s}}).state  # fmt: skip
    without = simulate(TABLE_1[75], duration_s=4.0, **robot).state
    k = round(missed_s / 0.005)
    steady = whole[-1, 3]
    assert late[60:, 3] == pytest.approx(whole[k + 60 :, 3], abs=0.01 * steady)
    assert np.abs(without[60:, 3] - whole[k + 60 :, 3]).max() > 0.03 * steady


@pytest.mark.parametrize("delay_s", [-0.1, -1 / 60, -1e-3, 1e-3, 1 / 60, 0.05, 0.5])
def test_a_delayed_start_takes_away_the_impulse_of_the_thrust_in_its_time(delay_s) -> None:
    late, t = two_plate_system().effect("time_offset").hooks["thrust"], np.linspace(0, 2, 20001)
    force = np.array([late(one, 0.0, 1.0, 1000.0, 0.008, 4.0, 0.005, delay_s)[0] for one in t])
    full = 0.005 * 0.5 * 1000.0 * 0.008 * 4.0**2
    error = 0.03 if abs(delay_s) < 0.03 else 0.1
    assert np.trapezoid(force, t) == pytest.approx(-full * delay_s, rel=error)


def test_side_measurements_predicted_by_functions_have_the_slopes_of_differences() -> None:
    """A spin-up of share 0.6 and 0.3 s loses 0.18 s: slopes 0.3 and 0.6; a sag of 0.04/s halves."""
    system = two_plate_system()
    point = system.parameter_vector(
        TABLE_1[100],
        {
            "motor_spin_up": {"missing_share": 0.6, "time_constant": 0.3},
            "battery_sag": {"loss_rate": 0.04, "settling_rate": 1e-4},
        },
    )
    slot, at = system.parameter_index, (point[None], trial_arguments([[0.0, 3.5, 3.0]]))
    value, slopes = predict_side_measurement(system, "lost_time", *at)
    assert value[0] == pytest.approx(0.18)
    assert slopes[0, slot["motor_spin_up.missing_share"]] == pytest.approx(0.3)
    assert slopes[0, slot["motor_spin_up.time_constant"]] == pytest.approx(0.6)
    assert slopes[0, slot["motor_spin_up.dead_time"]] == pytest.approx(0.6)
    assert np.count_nonzero(slopes) == 3
    for name in ("frequency_drift", "tail_beat_drift"):
        assert predict_side_measurement(system, name, *at)[0][0] == pytest.approx(-0.02, rel=1e-3)
    assert predict_side_measurement(system, "stated_ratio", *at)[0][0] == pytest.approx(
        -0.06, rel=1e-3
    )
    assert predict_side_measurement(system, "clock_ratio", *at)[0][0] == 0.0


def test_a_sag_that_follows_the_load_drifts_more_at_a_higher_frequency() -> None:
    """With an exponent of 2, twice the frequency has four times the drift."""
    system = two_plate_system()
    point = system.parameter_vector(
        TABLE_1[100], {"battery_sag": {"loss_rate": 0.04, "load_exponent": 2.0}}
    )
    means = trial_arguments([[0.0, 2.0, 3.0], [0.0, 4.0, 3.0]])
    drift, slopes = predict_side_measurement(
        system, "frequency_drift", np.tile(point, (2, 1)), means
    )
    assert drift[1] / drift[0] == pytest.approx(4.0)
    place = system.parameter_index["battery_sag.load_exponent"]
    assert slopes[:, place] == pytest.approx(drift * np.log(means[:, 1] / 3.5), rel=1e-3)


def test_a_force_with_the_heads_heading_turns_with_the_head() -> None:
    """A magnet in the head, a quarter turn from the core, meets the moment a quarter turn later."""
    force = two_plate_system().effect("yaw_with_heading").hooks["force"]
    core = [force(psi, 0.0, 0.2, 0.1, 1.0, 1.0)[2] for psi in (0.3, 1.1)]
    turned = [force(psi + np.pi / 2, np.pi / 2, 0.2, 0.1, 1.0, 1.0)[2] for psi in (0.3, 1.1)]
    assert turned == pytest.approx(core)
    assert force(0.3, np.pi / 2, 0.2, 0.1, 1.0, 0.0)[2] == pytest.approx(core[0])


@pytest.mark.parametrize(("name", "place"), [("sway_near_speed", 1), ("yaw_near_speed", 2)])
def test_a_force_about_one_speed_is_largest_there_and_a_quarter_at_its_width(name, place) -> None:
    force = two_plate_system().effect(name).hooks["force"]
    assert force(0.3, 0.02, 0.3, 0.1)[place] == pytest.approx(0.02)
    assert force(0.4, 0.02, 0.3, 0.1)[place] == pytest.approx(0.02 / 4)
    assert abs(force(1.0, 0.02, 0.3, 0.1)[place]) < 0.02 / 2000


@pytest.mark.parametrize("place", [(0.6, 0.4), (2.1, 0.4)])
def test_a_cable_pulls_towards_its_point_in_proportion_to_its_extension(place) -> None:
    """A point in the middle of the pool, 0.5 N/m, 0.2 m slack; the robot swims along y."""
    pull = two_plate_system().effect("pull_to_pool_point").hooks["force"]
    at = {"cpsi": 0.0, "spsi": 1.0, "L_pool": 2.6, "W_pool": 1.6, "length_unit": 1.0}
    away = np.array([1.3, 0.8]) - place
    distance = float(np.hypot(*away))
    surge, sway, moment = pull(*place, **at, k=0.5, s=0.2 / 2.6, a=0.5, b=0.5)
    expected = 0.5 * (distance - 0.2) * away / distance
    assert (-sway, surge) == pytest.approx(expected, abs=1e-5)
    assert moment == 0.0
    assert pull(*place, **at, k=0.5, s=0.6, a=0.5, b=0.5) == pytest.approx([0, 0, 0], abs=1e-6)


def test_a_cable_to_the_start_pulls_back_and_its_torsion_turns_back() -> None:
    system = two_plate_system()
    pull, twist = (system.effect(name).hooks["force"] for name in
                   ("pull_to_start", "torsion_since_start"))  # fmt: skip
    ahead = pull(1.5, 0.5, 0.5, 0.5, 1.0, 0.0, 2.6, 1.0, k=0.3, s=0.0)
    assert ahead == pytest.approx([-0.3, 0, 0], abs=1e-5)
    assert pull(0.5, 0.5, 0.5, 0.5, 1.0, 0.0, 2.6, 1.0, k=0.3, s=0.0) == pytest.approx([0, 0, 0])
    assert twist(7.0, 1.0, 0.01)[2] == pytest.approx(-0.06)


def test_simulated_cables_are_relative_to_the_start_of_the_path() -> None:
    """Held back by a cable from its start, and turned back by its torsion."""
    start = (0.7, 0.4, 0.3, 0.0, 0.0, 0.0)
    common = {"setup": PAPER_SETUP, "head_length_m": 0.12, "head_angle_rad": 0.3, "flap_hz": 4.0,
              "duration_s": 3.0, "start": start}  # fmt: skip
    free, held, twisted = (
        simulate(TABLE_1[100], **common, effects=effects)
        for effects in (
            None,
            {"pull_to_start": {"stiffness": 0.3}},
            {"torsion_since_start": {"stiffness": 0.02}},
        )
    )
    far = [np.hypot(*(run.state[-1, :2] - start[:2])) for run in (free, held)]
    assert far[1] < 0.9 * far[0]
    assert abs(twisted.heading_rad[-1] - 0.3) < 0.9 * abs(free.heading_rad[-1] - 0.3)


def lift_over_steady(e: float, w: float, speeds: np.ndarray) -> np.ndarray:
    """Lift by the lag's own equations over its steady value, 24 steps a head length travelled, at
    speeds one a step; k = 1, s = 1.5, sin 2 alpha = 0.6.
    """
    lag, h, (z, y) = two_plate_system().effect("lift_lag"), 0.12, (0.0, 0.0)
    out = []
    for V in speeds:
        known = {"uh": V * np.cos(0.5 * np.arcsin(-0.6)), "vh": V * np.sin(0.5 * np.arcsin(-0.6)),
                 "V": V, "C_La": 3.0, "rho": 1000.0, "A": 0.0083}  # fmt: skip
        missing = lag.hooks["head_plate_force"](**known, z=z, y_lag=y, k=1.0, w=w, e=e)
        out.append(1.0 - np.hypot(*missing) / (0.5 * 1000 * 0.0083 * 3.0 * 0.6 * V * V))
        assert lag.rates is not None
        dz, dy = lag.rates(known["uh"], known["vh"], V, h, 1.0, z, y, 1.5, e)
        step = h / 24 / V
        z, y = z + step * dz, y + step * dy
    return np.array(out)


@pytest.mark.parametrize("e", [0.0, 1.0, 2.0])
def test_lift_builds_up_over_the_lengths_travelled(e: float) -> None:
    """1 - exp(-x / s), and of two lags in series 1 - (1 + x / s) exp(-x / s)."""
    x = np.arange(240) / 24 / 1.5
    V = np.full(240, 0.3)
    assert lift_over_steady(e, 0.0, V) == pytest.approx(1 - np.exp(-x), abs=0.02)
    assert lift_over_steady(e, 1.0, V) == pytest.approx(1 - (1 + x) * np.exp(-x), abs=0.02)


def test_a_coefficient_that_lags_feels_the_speed_at_once() -> None:
    """Twice as fast after 10 lengths: a force that lags is at 1/4 there, a circulation at 1/2."""
    V = np.repeat([0.2, 0.4], 240)
    for e, share in ((0.0, 0.25), (1.0, 0.5), (2.0, 1.0)):
        assert lift_over_steady(e, 0.0, V)[240] == pytest.approx(share, abs=0.01)


def test_a_stall_goes_on_over_its_range() -> None:
    """Half of k is lost in the middle of the range, nothing before it and all of k beyond."""
    stall = two_plate_system().effect("stall")
    for s, share in ((0.19, 0.0), (0.25, 0.5), (0.31, 1.0)):
        motion = {"uh": 0.3 * np.sqrt(1 - s * s), "vh": 0.3 * s, "V": 0.3}
        rest = call_effect(stall, "rates", np.zeros(3), **motion, z_stall=share, s0=0.2, b=0.1)
        assert rest == pytest.approx([0.0], abs=1e-5)
        lost = call_effect(stall, "head_plate_force", np.zeros(3), **motion, k=0.4, z_stall=share)
        lift = 0.5 * 1000 * 0.0083 * 3.0 * 2 * 0.09 * s * np.sqrt(1 - s * s)
        assert np.hypot(*lost) == pytest.approx(0.4 * share * lift)


def test_flow_separates_while_the_head_travels_its_lengths() -> None:
    """3 head lengths of 0.12 m at 0.3 m/s: a time constant of 1.2 s, and the least lag, 1/60 s."""
    stall = two_plate_system().effect("stall")
    motion = {"uh": 0.24, "vh": 0.18, "V": 0.3, "s0": 0.2, "b": 0.1}  # fully separated
    rate = call_effect(stall, "rates", np.zeros(3), **motion, z_stall=0.4, s=3.0)
    assert rate == pytest.approx([0.6 / (1.2 + 1 / 60)])
    alone = call_effect(stall, "head_plate_force", np.zeros(3), **motion, z_stall=1.0, j=0.0)
    assert alone == pytest.approx([0.0, 0.0])


def test_a_wall_fades_by_e_or_as_the_square_of_the_distance() -> None:
    """0.2 m from one wall, the others far away: exp(-2) or 1/5 of 1/2 rho A V^2 at s = 0.1 m."""
    wall, far = (
        two_plate_system().effect("wall_effect"),
        {"L_pool": 900.0, "W_pool": 900.0, "y": 450.0},
    )
    for w, share in ((0.0, np.exp(-2.0)), (1.0, 1 / 5)):
        X, Y, _ = call_effect(wall, "force", np.array([0.3, 0.0, 0.0]), **far, x=0.2, k=1.0, s=0.1,
                       w=w, g=0.0)  # fmt: skip
        assert pytest.approx((-0.5 * 1000 * 0.0083 * share * 0.09, 0.0), rel=1e-4) == (X, Y)


def test_thrust_lost_by_the_speed_alone_is_a_share_of_it() -> None:
    """q = 1: dT / f^2 as the speed says; q = 0: dT / f^2 as the advance says."""
    loss = two_plate_system().effect("thrust_loss_with_speed")

    def share(f: float, **given: float) -> float:
        return call_effect(loss, "thrust", np.array([0.3, 0.0, 0.0]), f=f, **given)[0] / f**2

    assert share(5.0, w=0.0, q=1.0) == pytest.approx(share(2.5, w=0.0, q=1.0))
    assert share(5.0, w=1.0, q=2.0) == pytest.approx(share(2.5, w=1.0, q=2.0))
    assert share(5.0, w=0.0, q=0.0) == pytest.approx(0.5 * share(2.5, w=0.0, q=0.0))
    assert share(3.5, w=0.3, q=1.4) == pytest.approx(share(3.5, w=0.3, q=0.0))


def test_displacements_are_relative_to_the_most_certain_one() -> None:
    """Turned by a right angle and twice as far: (dx, dy) times 2 i."""
    camera_shift = two_plate_system().effect("camera_shift")
    seen = camera_shift.hooks["observe"](3.0, 1.0, 2.0, 0.0, 2.0, 0.004, 0.001)
    assert seen == pytest.approx((-0.002, 0.008, 0.0, 0.0))
    assert camera_shift.hooks["observe"](1.9, 1.0, 2.0, 0.0, 2.0, 0.004, 0.001) == (
        0.0,
        0.0,
        0.0,
        0.0,
    )


@pytest.mark.parametrize("name", ["stall", "lift_lag", "port_starboard_asymmetry"])
def test_the_moment_goes_as_the_lift_does(name: str) -> None:
    """Moment over force is C_Ma over C_La in the part m; none is the start."""
    effect, late = two_plate_system().effect(name), {"z": 0.01, "y_lag": 0.02}
    given = {"stall": {"s0": 0.1}, "lift_lag": {}}.get(name, {"n": 0.0, "g": 0.0})
    motion = np.array([0.3, -0.2, 0.4])
    lift = np.hypot(*call_effect(effect, "head_plate_force", motion, **late, **given))
    X, Y, N = call_effect(effect, "force", motion, **late, **given, m=0.8)
    assert (X, Y) == (0.0, 0.0)
    assert abs(N) == pytest.approx(0.8 * lift * 0.1 / 3.0, rel=1e-9)
    assert call_effect(effect, "force", motion, **late, **given)[2] == 0.0


@pytest.mark.parametrize("step", [1 / 30, 1 / 60])
def test_a_core_is_not_wound_by_the_first_step(step: float) -> None:
    """Runge and Kutta's rule of a rate that is known is Simpson's; the least n is the worst."""
    effect = two_plate_system().effect("servo_lag")
    n = next(p.lower for p in effect.parameters if p.symbol == "n")
    t = np.arange(0.0, 6.0, 0.5 * step)
    turn_rate = effect.hooks["core_turn_rate"]
    rate = np.array(
        [turn_rate(one, 0.5, 0.0, 1.0, 0.2, n, 0.5, 1.0, 0.0, 0.0, 3.0, 0.0)[0] for one in t]
    )
    turned = step / 6 * (rate[:-2:2] + 4 * rate[1:-1:2] + rate[2::2]).sum()
    assert turned == pytest.approx(0.5, abs=0.01)


def test_a_core_that_takes_the_turning_goes_with_the_head_angle() -> None:
    """Over the whole start it turns by c times what was missing of the angle; c = 0: not at all."""
    servo, t = two_plate_system().effect("servo_lag").hooks, np.linspace(0.0, 4.0, 40001)
    for n, q, w in ((1.0, 0.0, 0.0), (2.2, 0.6, 0.0), (1.0, 0.0, 1.0), (1.5, 0.3, 0.5)):
        given, swing = (-0.1, 0.8, 0.3, n, q), (w, 3.0, 1.0)
        missing = servo["actuation_inputs"](0.0, 0.5, *given, 0.2, *swing)[0]
        assert missing == pytest.approx(-0.8 * (0.5 + 0.1), rel=1e-3)
        turn = [servo["core_turn_rate"](one, 0.5, *given, 0.7, 0.2, *swing)[0] for one in t]
        assert np.trapezoid(turn, t) == pytest.approx(-0.7 * missing, rel=2e-3)
        assert servo["core_turn_rate"](0.1, 0.5, *given, 0.0, 0.0, *swing) == (0.0,)


def test_an_overshooting_servo_is_the_step_response_of_second_order() -> None:
    """Nise (2015), sec. 4.6: damping ratio 0.3, 5 rad/s, from rest at the angle 0."""
    ratio, natural = 0.3, 5.0
    damped = np.sqrt(1 - ratio**2)
    drive = two_plate_system().effect("servo_lag").hooks["actuation_inputs"]
    for t in (0.05, 0.4, 1.1, 2.0):
        z = damped * natural * t
        reached = 1 - np.exp(-ratio * natural * t) * (np.cos(z) + ratio / damped * np.sin(z))
        given = (1.0, 1 / (ratio * natural), 1.0, 0.0, 0.0, 1.0, damped / ratio)
        missing = drive(t, 0.5, 0.0, *given, 0.0)[0]
        assert missing == pytest.approx(-0.5 * (1 - reached), abs=1e-8)


def test_a_servo_does_not_move_in_its_dead_time() -> None:
    drive = two_plate_system().effect("servo_lag").hooks["actuation_inputs"]
    given = {"phi0": 0.0, "k": 1.0, "tau": 0.3, "n": 1.0, "q": 0.0, "w": 0.0, "b": 3.0, "s": 0.0}
    assert drive(0.15, 0.5, **given, t_d=0.2)[0] == pytest.approx(-0.5, rel=1e-6)
    assert drive(0.5, 0.5, **given, t_d=0.2) == pytest.approx(drive(0.3, 0.5, **given, t_d=0.0))


def wave_drag_newton(speed_m_s: float, **form: float) -> float:
    """Wave drag of k = 1 N (s/m)^4 in straight swimming."""
    none = {"w": 0.0, "h": 0.0, "g": 0.0, "V_c": 0.35, "o": 0.0, "V_0": 0.23}
    force = two_plate_system().effect("wave_drag").hooks["force"]
    return -force(0.1, speed_m_s, 0.0, speed_m_s, 1.0, 1.0, **none | form)[0]


def test_forms_of_wave_drag_are_alike_at_their_reference_speed() -> None:
    """All are 0.4^4 N at 0.4 m/s for k = 1, the hump where its peak is there."""
    forms = ({}, {"w": 1.0}, {"o": 1.0}, {"g": 1.0, "V_c": 0.4})
    assert [wave_drag_newton(0.4, **form) for form in forms] == pytest.approx([0.4**4] * 4)


def test_no_waves_below_the_least_speed_of_waves() -> None:
    """Raphael and de Gennes (1996): none below 0.23 m/s; then as the square of the excess."""
    assert wave_drag_newton(0.229, o=1.0) == 0.0
    twice = wave_drag_newton(0.43, o=1.0) / wave_drag_newton(0.33, o=1.0)
    assert twice == pytest.approx(4.0)


def test_a_centre_of_mass_moves_with_the_turned_head() -> None:
    """With w = 1 it is shifted by d at 45 degrees, to both sides, and not with a straight head."""
    observe = two_plate_system().effect("centre_of_mass_shift").hooks["observe"]
    for side in (1.0, -1.0):
        turned = observe(1.0, 0.0, side * np.sin(np.pi / 4), 0.01, 0.0, 1.0)
        assert turned == pytest.approx((-0.01, 0.0, 0.0, 0.0))
    assert observe(1.0, 0.0, 0.0, 0.01, 0.0, 1.0) == (0.0, 0.0, 0.0, 0.0)
    force = two_plate_system().effect("centre_of_mass_shift").hooks["force"]
    assert force(0.2, 0.0, 0.3, 1.0, 0.0, 0.01, 0.0, 0.0)[2] == pytest.approx(-0.003)


def test_a_label_that_follows_the_turned_head_errs_to_the_side_of_the_head() -> None:
    observe = two_plate_system().effect("keypoint_bias").hooks["observe"]
    given = {"bx": 0.0, "by": 0.004, "bpsi": 0.02, "bphi": 0.03, "w": 1.0}
    left = observe(1.0, 0.0, np.sin(np.pi / 4), **given)
    right = observe(1.0, 0.0, -np.sin(np.pi / 4), **given)
    assert left == pytest.approx((0.0, 0.004, 0.02, 0.03))
    assert np.add(left, right) == pytest.approx(0.0)


def test_added_mass_without_its_munk_moment() -> None:
    """Kirchhoff's -(A22 - A11) u v, given back where e = 0."""
    added = two_plate_system().effect("added_mass").hooks["force"]
    assert added(0.3, 0.1, 0.2, 0.25, 0.0) == pytest.approx((0, 0, (0.2 - 0.05) * 0.3 * 0.1))
    assert added(0.3, 0.1, 0.2, 0.25, 1.0) == (0.0, 0.0, 0.0)


def test_terms_of_head_angle_and_side() -> None:
    """A constant and f in yaw; u^2 sin phi in sway."""
    none = {p.name: 0.0 for p in residual.EFFECT_PARAMETERS}
    given = {"cpsi": np.cos(0.7), "spsi": np.sin(0.7), "sphi": np.sin(0.5), "f": 4.0}
    strengths = {"sway_u2_sinphi": 2.0, "yaw_constant": 0.1, "yaw_f": 0.2}
    X, Y, N = call_effect(two_plate_system().effect("residual"), "force", np.array([0.3, 0.0, 0.0]),
                   **none | given | strengths)  # fmt: skip
    expected = 0.1 + 0.2 * 4
    assert pytest.approx((0.0, 2 * 0.09 * np.sin(0.5), expected)) == (X, Y, N)


def test_crossflow_drag_of_a_tapering_body() -> None:
    """Depth from (1 + q) d at the hinge to (1 - q) d at the tail base, by fine strips."""
    found = call_effect(
        two_plate_system().effect("crossflow_drag"), "force", np.array([0.0, 0.2, 0.5]), q=0.6
    )
    x = np.linspace(0.04, -0.171, 4001)
    depth = 0.069 * (1 + 0.6 * (2 * (x + 0.171) / 0.211 - 1))
    dY = -0.5 * 1000 * 0.5 * depth * (0.2 + 0.5 * x) * np.abs(0.2 + 0.5 * x)
    Y, N = np.trapezoid(dY, -x), np.trapezoid(x * dY, -x)
    assert found == pytest.approx([0.0, Y, N], rel=1e-5)


def test_crossflow_drag_of_a_deep_tail() -> None:
    """A tail of 0.07 m, two spans deep, that moves sideways at 0.2 - 0.206 m x 0.5 rad/s."""
    effect, motion = two_plate_system().effect("crossflow_drag"), np.array([0.0, 0.2, 0.5])
    added = np.subtract(
        call_effect(effect, "force", motion, j=2.0), call_effect(effect, "force", motion, j=0.0)
    )
    Y = -0.5 * 1000 * 0.5 * 2 * 0.069 * 0.07 * (0.2 - 0.206 * 0.5) ** 2
    assert added == pytest.approx([0.0, Y, -0.206 * Y])


@pytest.mark.parametrize(("b", "c"), [(0.0, 0.0), (0.4, 0.3), (1.0, 0.0), (0.0, 1.0)])
def test_the_eddy_turns_a_line_as_its_velocities_differ_along_it(b: float, c: float) -> None:
    eddy = two_plate_system().effect("pool_gyre").hooks["ambient_flow"]
    place, psi, step = np.array([0.7, 1.1]), 0.6, 1e-6
    along, left = np.array([np.cos(psi), np.sin(psi)]), np.array([-np.sin(psi), np.cos(psi)])
    ahead, behind = (eddy(*(place + k * step * along), psi, 2.6, 1.6, 0.02, 1.0, 0.5, b, c, 0.7)[:2]
                     for k in (1, -1))  # fmt: skip
    turning = (np.subtract(ahead, behind) / (2 * step)) @ left
    assert eddy(*place, psi, 2.6, 1.6, 0.02, 1.0, 0.5, b, c, 0.7)[2:] == pytest.approx(
        (turning, 0.5 * turning), rel=1e-6
    )


def test_water_that_turns_with_the_robot_damps_nothing_and_meets_the_plate_at_its_arm() -> None:
    w, arm = 0.3, 0.1
    rc, rd, uh, vh = relative_flow_velocities(arm, 0.4, 0.0, 0.0, w, 1.0, 0.0, 0.0, 0.0, w, w)[4:8]
    assert (rc, rd, uh, vh) == (0.0, 0.0, 0.0, -arm * w)  # r l itself the paper leaves out


@pytest.mark.parametrize(("p", "q", "power"), [(0, 0, 1.0), (1, 0, 1.5), (0, 1, 1.0)])
def test_yaw_damping_grows_with_its_power_of_the_yaw_rate(p, q, power) -> None:
    damping, motion = two_plate_system().effect("linear_yaw_damping"), np.array([0.3, 0.0, 0.5])
    slow = call_effect(damping, "force", motion, p=p, q=q)[2]
    assert slow == pytest.approx(-0.005 * 0.5)
    fast = call_effect(damping, "force", motion * np.array([1, 1, 2]), p=p, q=q)[2]
    assert fast == pytest.approx(slow * 2**power)
    ahead = call_effect(damping, "force", motion * np.array([2, 1, 1]), p=p, q=q)[2]
    assert ahead == pytest.approx(slow * (1 + q))


def test_friction_of_stribeck_is_larger_at_rest_by_its_excess() -> None:
    friction = two_plate_system().effect("coulomb_friction")
    near, far = (call_effect(friction, "force", np.array([u, 0.0, 0.0]), c=1e-3, s=0.5)[0]
                 for u in (0.01, 1.0))  # fmt: skip
    assert far == pytest.approx(-0.02, rel=1e-4)
    assert near == pytest.approx(-0.02 * (1 + 0.5 * np.exp(-0.01)), rel=0.01)


def test_crossflow_drag_that_falls_with_the_reynolds_number_has_the_power_three_halves() -> None:
    drag = two_plate_system().effect("crossflow_drag")
    low, high = (call_effect(drag, "force", np.array([0.0, v, 0.0]), e=1.0)[1] for v in (0.1, 0.4))
    assert high == pytest.approx(low * 4**1.5)
    assert low == pytest.approx(call_effect(drag, "force", np.array([0.0, 0.1, 0.0]))[1])


def test_a_trim_moment_of_the_thrust_goes_with_the_beat_alone() -> None:
    trim = two_plate_system().effect("trim_moment")
    moments = [call_effect(trim, "force", np.array([u, 0.0, 0.0]), w=1.0, f=f)[2]
               for u, f in ((0.1, 3.5), (0.4, 3.5), (0.4, 7.0))]  # fmt: skip
    assert moments == pytest.approx(0.045 * 1000 * 0.0083 * 0.001 * np.array([1, 1, 4]))


def test_a_head_with_a_wrong_gain_or_play_errs_with_its_angle_or_side() -> None:
    drive = two_plate_system().effect("head_angle_offset").hooks["actuation_inputs"]
    angles = np.radians([-35.0, 17.5, 35.0])
    gain = [drive(a, 0.02, 1.0, 0.0)[0] for a in angles]
    assert gain == pytest.approx([-0.02, 0.01, 0.02])
    play = [drive(a, 0.02, 0.0, 1.0)[0] for a in angles]
    assert play == pytest.approx([-0.02, 0.02, 0.02], rel=2e-3)


def test_a_wake_that_fades_counts_by_its_age() -> None:
    """Two turns at 1.047 rad/s: an age of 6 s; half of that rate and a decay of 1: half of it."""
    wake, motion = two_plate_system().effect("wake_reentry"), np.array([0.3, 0.0, 2 * np.pi / 6])
    given = {"psi": 4 * np.pi, "n_1": 1.0, "a": 1.0}
    X = call_effect(wake, "force", motion, **given)[0]
    assert pytest.approx(0.5 * 1000 * 0.0083 * 0.2 * 0.09) == X
    assert call_effect(wake, "force", motion * [1, 0, 0.5], **given)[0] == pytest.approx(0.5 * X)
    assert call_effect(wake, "force", motion, **given, g=0.5)[0] == pytest.approx(1.5 * X)
    assert call_effect(wake, "force", motion * [0.5, 0, 1], **given, j=1.0)[0] == pytest.approx(
        0.5 * X
    )


def test_a_robot_that_settles_has_sunk_by_its_first_rate_over_the_settling_rate() -> None:
    seen = two_plate_system().effect("sinking").hooks["observe"]
    late = seen(20.0, 1.0, 2.3, 0.8, 1.3, 0.8, 0.002, 0.0, 1.0)
    assert late == pytest.approx((-0.002, 0.0, 0.0, 0.0))
    steady = seen(2.0, 1.0, 2.3, 0.8, 1.3, 0.8, 0.002, 0.0, 1e-4)
    assert steady[0] == pytest.approx(-0.004, rel=1e-3)


def test_a_sheared_current_vanishes_at_one_wall_and_doubles_at_the_other() -> None:
    current = two_plate_system().effect("uniform_current").hooks["ambient_flow"]
    across = [current(3.0, 1.3, y, 2.6, 1.6, 1.0, 0.01, 0.0, 1.0, 0.0)[0] for y in (0.0, 0.8, 1.6)]
    assert across == pytest.approx([0.0, 0.01, 0.02])
    assert current(6.0, 1.3, 0.8, 2.6, 1.6, 1.0, 0.01, 0.0, 0.0, -1.0)[0] == pytest.approx(0.0)


def test_a_vortex_is_fastest_at_its_core_radius() -> None:
    water = two_plate_system().effect("pool_gyre").hooks["ambient_flow"]
    speeds = [water(1.3 + r, 0.8, 0.0, 2.6, 1.6, 0.02, 0.0, 0.0, 1.0, 0.0, 0.4)[1]
              for r in (0.2, 0.4, 0.8)]  # fmt: skip
    assert speeds == pytest.approx([0.016, 0.02, 0.016])


def test_a_wall_that_sucks_pulls_across_a_robot_beside_it() -> None:
    wall = two_plate_system().effect("wall_effect")
    given = {"L_pool": 900.0, "W_pool": 900.0, "x": 450.0, "y": 0.1, "s": 0.1, "w": 0.0,
             "cpsi": 1.0, "spsi": 0.0}  # fmt: skip
    force = call_effect(wall, "force", np.array([0.3, 0.0, 0.0]), **given, k=1.0, g=0.5, j=0.2)
    near = 0.5 * 1000 * 0.0083 * np.exp(-1) * 0.09
    assert pytest.approx((-near, -0.5 * near, -0.02 * near), rel=1e-4) == force


def test_a_side_that_damps_more_adds_its_part_of_the_yaw_damping() -> None:
    side = two_plate_system().effect("port_starboard_asymmetry")
    left, right = (
        call_effect(side, "force", np.array([0.0, 0.0, r]), n=0.1)[2] for r in (0.5, -0.5)
    )
    assert left == right == pytest.approx(0.1 * 0.12 * 0.25)


def test_drag_that_differs_between_the_sides_adds_on_one_and_lacks_on_the_other() -> None:
    """0.2 C_Da (1 - cos 2 alpha) of 1/2 rho A V^2, against the flow with the lift to the left."""
    side = two_plate_system().effect("port_starboard_asymmetry")
    for vh, sign in ((-0.1, 1.0), (0.1, -1.0)):
        given = {"uh": 0.3, "vh": vh, "V": np.hypot(0.3, 0.1)}
        X, Y = call_effect(side, "head_plate_force", np.zeros(3), **given, k=0.0, g=0.2, w=0.0)
        drag = sign * 0.5 * 1000 * 0.0083 * 2.0 * 0.2 * 2 * 0.01
        assert -(X * 0.3 + Y * vh) / np.hypot(0.3, 0.1) == pytest.approx(drag)
