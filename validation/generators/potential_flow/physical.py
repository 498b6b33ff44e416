"""Functional forms of the physical causes in STUDY.md that change the motion."""

from __future__ import annotations

from . import fins, motors
from . import headlaws as hd
from . import resistance as rs
from . import surroundings as su
from .form import forms as _forms

SWAY_YAW = ("sway", "yaw")
ALL_CHANNELS = ("surge", "sway", "yaw")

DELAY_RANGES = {"tau": (0.15, 0.5)}
DIRECTION_RANGES = {"bearing": (0.0, 6.28)}
TURNS_UNTIL_WAKE_RANGES = {"turn": (1.5, 2.6)}
STALL_RANGES = {"onset": (0.05, 0.09), "width": (0.008, 0.02)}
CHORD_RANGES = {"chords": (1.5, 5.0)}
WALL_RANGES = {"reach": (0.15, 0.4)}

MOTION_FORMS = [
    *_forms(
        "tail_fin_lift",
        "force",
        "1",
        SWAY_YAW,
        [
            ("vortex_lattice", fins.lattice_fin, 0.005, 30.0, {}, fins.lattice_wake, 1),
            ("lighthill", fins.lighthill_fin, 0.005, 30.0),
            ("polhamus", fins.polhamus_fin, 0.005, 30.0, {"K_p": (1.5, 3.0)}),
            ("resultant_speed", fins.resultant_fin, 0.005, 30.0),
            ("separating", fins.separating_fin, 0.005, 30.0, {"onset": (0.3, 0.6)}),
        ],
    ),
    *_forms(
        "crossflow_drag",
        "force",
        "1",
        SWAY_YAW,
        [
            ("strips", fins.crossflow_strips, 0.02, 6.0),
            ("tapered", fins.crossflow_tapered, 0.02, 6.0),
            ("power", fins.crossflow_power, 0.02, 6.0, {"power": (1.5, 1.8)}),
            ("reynolds", fins.crossflow_reynolds, 0.02, 6.0, {"w_0": (0.01, 0.05)}),
        ],
    ),
    *_forms(
        "linear_yaw_damping",
        "force",
        "N m s",
        ("yaw",),
        [
            ("stokes", rs.yaw_damping_stokes, 2e-4, 0.1),
            ("boundary_layer", rs.yaw_damping_boundary_layer, 2e-4, 0.1),
            ("translating", rs.yaw_damping_with_speed, 5e-4, 0.3),
        ],
    ),
    *_forms(
        "added_mass",
        "mass",
        "1",
        ALL_CHANNELS,
        [
            ("spheroid", su.added_mass_spheroid, 0.01, 2.5),
            ("slender", su.added_mass_slender, 0.01, 2.5),
            ("tapered", su.added_mass_tapered, 0.01, 2.5),
        ],
    ),
    *_forms("added_mass", "force", "1", ("yaw",), [("munk", su.added_mass_munk, 0.003, 1.2)]),
    *_forms(
        "viscous_drag",
        "force",
        "SI",
        ("surge", "sway"),
        [
            ("stokes", rs.viscous_stokes, 3e-3, 0.8),
            ("blasius", rs.viscous_blasius, 5e-3, 1.5),
            ("prandtl", rs.viscous_prandtl, 0.02, 3.0),
            ("ittc", rs.viscous_ittc, 0.05, 12.0),
        ],
    ),
    *_forms(
        "wave_drag",
        "force",
        "SI",
        ("surge", "sway"),
        [
            ("quartic", rs.wave_quartic, 0.05, 20.0),
            ("sixth", rs.wave_sixth, 0.1, 120.0),
            ("havelock", rs.wave_havelock, 1e-3, 3.0),
            ("onset", rs.wave_onset, 0.05, 20.0, {"V_0": (0.15, 0.25)}),
        ],
    ),
    *_forms(
        "coulomb_friction",
        "force",
        "N",
        ("surge", "sway"),
        [
            ("sign", rs.coulomb_sign, 5e-4, 0.05),
            ("tanh", rs.coulomb_tanh, 5e-4, 0.05, {"V_0": (0.01, 0.05)}),
            ("stribeck", rs.coulomb_stribeck, 5e-4, 0.05, {"V_s": (0.05, 0.15)}),
            ("saturating", rs.coulomb_saturating, 5e-4, 0.06, {"V_0": (0.02, 0.06)}),
        ],
    ),
    *_forms(
        "thrust_loss_with_speed",
        "thrust",
        "1",
        ("surge",),
        [
            ("linear", motors.thrust_loss_linear, 5e-3, 0.45),
            ("square", motors.thrust_loss_quadratic, 4e-3, 0.3),
            ("exponential", motors.thrust_loss_exponential, 5e-3, 0.8),
            ("strouhal", motors.thrust_loss_strouhal, 5e-3, 0.6, {"J_0": (0.7, 1.1)}),
        ],
    ),
    *_forms(
        "thrust_area",
        "thrust",
        "1",
        ("surge",),
        [
            ("blend", motors.thrust_area_blend, 0.05, 1.3),
            ("power", motors.thrust_area_power, 0.05, 1.3),
            ("harmonic", motors.thrust_area_harmonic, 0.05, 1.3),
        ],
    ),
    *_forms(
        "battery_sag",
        "motor",
        "1",
        ("surge",),
        [
            ("linear", motors.sag_linear, 5e-4, 0.3),
            ("exponential", motors.sag_exponential, 5e-4, 0.3, {"tau": (2.0, 4.0)}),
            ("hyperbolic", motors.sag_hyperbolic, 5e-4, 0.4, {"tau": (4.0, 10.0)}),
            ("load", motors.sag_load_dependent, 5e-4, 0.4),
        ],
    ),
    *_forms(
        "motor_spin_up",
        "motor",
        "s",
        ("surge",),
        [
            ("first_order", motors.spin_up_first_order, 3e-4, 0.8),
            ("second_order", motors.spin_up_critically_damped, 3e-4, 0.5),
            ("ramp", motors.spin_up_ramp, 6e-4, 0.7),
            ("s_curve", motors.spin_up_s_curve, 6e-4, 0.7),
        ],
    ),
    *_forms(
        "stall",
        "head",
        "1",
        ALL_CHANNELS,
        [
            ("step", hd.stall_step, 0.01, 0.95, STALL_RANGES),
            ("kirchhoff", hd.stall_kirchhoff, 0.01, 0.99, STALL_RANGES),
            (
                "goman_khrabrov",
                hd.stall_goman_khrabrov,
                0.01,
                0.99,
                {**STALL_RANGES, "lag": (1.0, 4.0)},
                hd.separation_rate,
                1,
            ),
            ("lift_and_moment", hd.stall_both, 0.01, 0.95, STALL_RANGES),
        ],
    ),
    *_forms(
        "lift_lag",
        "head",
        "1",
        SWAY_YAW,
        [
            (
                "coefficient",
                hd.lag_coefficient,
                0.02,
                1.0,
                CHORD_RANGES,
                hd.lag_coefficient_state,
                1,
            ),
            (
                "circulation",
                hd.lag_circulation,
                0.02,
                1.0,
                CHORD_RANGES,
                hd.lag_circulation_state,
                1,
            ),
            ("wagner", hd.lag_wagner, 0.02, 1.0, {"stretch": (0.5, 1.5)}, hd.lag_wagner_state, 2),
        ],
    ),
    *_forms(
        "servo_lag",
        "servo",
        "1",
        SWAY_YAW,
        [
            ("first_order", motors.servo_first_order, 2e-3, 1.0, DELAY_RANGES),
            ("second_order", motors.servo_second_order, 2e-3, 1.0, DELAY_RANGES),
            (
                "underdamped",
                motors.servo_underdamped,
                2e-3,
                1.0,
                {**DELAY_RANGES, "damping": (0.3, 0.7)},
            ),
            ("rate_limit", motors.servo_rate_limited, 2e-3, 1.0, DELAY_RANGES),
            ("dead_time", motors.servo_dead_time, 2e-3, 1.0, DELAY_RANGES),
        ],
    ),
    *_forms(
        "port_starboard_asymmetry",
        "head",
        "1",
        SWAY_YAW,
        [
            ("step", hd.asymmetry_step, 2e-3, 0.5),
            ("tanh", hd.asymmetry_tanh, 2e-3, 0.5, {"width": (0.03, 0.1)}),
            ("large_angles", hd.asymmetry_beyond_onset, 2e-3, 0.5, {"onset": (0.04, 0.07)}),
            ("with_drag", hd.asymmetry_with_drag, 2e-3, 0.5),
        ],
    ),
    *_forms(
        "trim_moment",
        "force",
        "SI",
        ("yaw",),
        [
            ("square", rs.trim_square, 3e-4, 0.06),
            ("forward", rs.trim_forward, 3e-4, 0.06),
            ("thrust", rs.trim_thrust, 5e-5, 0.01),
            ("motor", rs.trim_motor, 5e-6, 1.5e-3),
        ],
    ),
    *_forms(
        "head_angle_offset",
        "servo",
        "rad",
        SWAY_YAW,
        [
            ("constant", motors.offset_constant, 2e-3, 0.12),
            ("gain", motors.offset_gain, 4e-3, 0.3),
            ("backlash", motors.offset_backlash, 2e-3, 0.12),
        ],
    ),
    *_forms(
        "thrust_line_offset",
        "force",
        "m",
        ("yaw",),
        [
            ("sine", rs.thrust_line_sine, 2e-4, 0.03),
            ("angle", rs.thrust_line_linear, 2e-4, 0.03),
            ("double", rs.thrust_line_double_angle, 1e-4, 0.02),
        ],
    ),
    *_forms(
        "centre_of_mass_shift",
        "balance",
        "m",
        ("yaw",),
        [
            ("along_core", su.mass_shift_along_core, 2e-4, 0.04),
            ("sliding", su.mass_shift_with_angle, 2e-4, 0.06),
            ("heavy_head", su.mass_shift_with_head, 2e-4, 0.04),
        ],
    ),
    *_forms(
        "uniform_current",
        "water",
        "m/s",
        ("surge", "sway"),
        [
            ("constant", su.current_constant, 5e-4, 0.06, DIRECTION_RANGES),
            ("drifting", su.current_drifting, 5e-4, 0.06, {**DIRECTION_RANGES, "turn": (0.5, 1.5)}),
            ("sheared", su.current_sheared, 5e-4, 0.06),
        ],
    ),
    *_forms(
        "pool_gyre",
        "water",
        "m/s",
        ("surge", "sway"),
        [
            ("cell", su.gyre_cell, 5e-4, 0.08),
            ("two_cells", su.gyre_two_cells, 5e-4, 0.08),
            ("lamb_oseen", su.gyre_lamb_oseen, 5e-4, 0.08, {"c": (0.3, 0.7)}),
            ("scully", su.gyre_scully, 5e-4, 0.08, {"c": (0.3, 0.7)}),
        ],
    ),
    *_forms(
        "wall_effect",
        "force",
        "1",
        ("surge", "sway"),
        [
            ("exponential", su.wall_exponential, 5e-3, 2.0, WALL_RANGES),
            ("power_law", su.wall_power, 3e-3, 1.0, WALL_RANGES),
            ("image_suction", su.wall_suction, 3e-3, 1.0, WALL_RANGES),
            ("cushion", su.wall_cushion, 5e-3, 2.0, {"reach": (0.3, 0.6)}),
        ],
    ),
]
