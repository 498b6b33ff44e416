"""What may be concealed in a study's physics: each effect with the forms of its law.

A form says which numbers of `swimmer.Laws` it sets. `strength` multiplies `weights`; `fixed` are
set as they are; `shape` is drawn between two bounds. `reported_as` names, for forms equal to
the candidate's, the candidate's parameter and the factor to it (None: another law).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["PHYSICS", "UNLISTED", "Effect", "Form"]

Span = tuple[float, float]


@dataclass(frozen=True)
class Form:
    """One law of an effect."""

    law: str
    weights: Mapping[str, float]
    fixed: Mapping[str, float] = field(default_factory=dict)
    shape: Mapping[str, Span] = field(default_factory=dict)
    reported_as: Mapping[str, tuple[str, float]] | None = None


@dataclass(frozen=True)
class Effect:
    """A concealed effect: statement, channels, variables it depends on, strengths, forms.

    usual, most: a strength to start from and the largest that is plausible. signed: either sign.
    direction: the two numbers that a drawn direction in the pool spreads the strength over.
    """

    statement: str
    channels: tuple[str, ...]
    variables: tuple[str, ...]
    usual: float
    most: float
    forms: tuple[Form, ...]
    signed: bool = False
    direction: tuple[str, str] | None = None


def _form(
    law: str, number: str, reported: str | None = None, factor: float = 1.0, **more: Span
) -> Form:
    """A form with one number; of `more`, ending in `_law` or `_power` fixed, others drawn."""
    fixed = {k: v[0] for k, v in more.items() if v[0] == v[1]}
    shape = {k: v for k, v in more.items() if v[0] != v[1]}
    return Form(
        law, {number: 1.0}, fixed, shape, {reported: (number, factor)} if reported else None
    )


def _fixed(value: float) -> Span:
    return value, value


SPEED = ("speed_m_s", "flap_hz")
TURN = ("yaw_rate_rad_s", "sway_speed_m_s", "angle_of_attack_rad", "head_angle_rad", "side")
PLACE = ("x_m", "y_m")
TIME = ("time_s", "heading_turned_rad")
LENGTH = ("head_length_m",)

PHYSICS: Mapping[str, Effect] = {
    "tail_fin_lift": Effect(
        "core and tail as a fin", ("sway", "yaw"), (*TURN, *SPEED), 0.025, 0.06,
        (Form("one point", {"fin_m2": 1.0}, {}, {"fin_arm_m": (0.09, 0.17)},
              {"lift_area": ("fin_m2", 1.0), "arm": ("fin_arm_m", 1.0)}),
         Form("strips", {"fin_m2": 1.0}, {"fin_spread_m": 0.045}, {"fin_arm_m": (0.09, 0.15)})),
    ),
    "added_mass": Effect(
        "water accelerated with the body", ("surge", "sway", "yaw"), (*TURN, *TIME, *SPEED),
        0.2, 0.9,
        (_form("slender body", "added_sway_kg", "sway_mass"),
         _form("ellipsoid", "added_sway_kg", added_surge_share=(0.04, 0.16),
               added_yaw_share=(0.6, 1.0))),
    ),
    "viscous_drag": Effect(
        "skin friction", ("surge", "sway"), SPEED, 0.3, 2.0,
        (_form("v^1.5, laminar", "friction", "coefficient", friction_power=_fixed(1.5)),
         _form("v, creeping", "friction", friction_power=_fixed(1.0))),
    ),
    "linear_yaw_damping": Effect(
        "friction of turning", ("yaw",), TURN, 0.015, 0.12, (_form("N r", "yaw_friction", "N_r"),)
    ),
    "thrust_loss_with_speed": Effect(
        "slip of the tail", ("surge",), SPEED, 3.0, 9.0,
        (_form("linear", "slip_per_m", slip_law=_fixed(0)),
         _form("exponential", "slip_per_m", slip_law=_fixed(1)),
         _form("square", "slip_per_m", slip_law=_fixed(2))),
    ),
    "uniform_current": Effect(
        "the water drifts", ("surge", "sway"), (*PLACE, *TIME, *SPEED, *TURN), 0.01, 0.08,
        (Form("even", {"current_x": 1.0, "current_y": 1.0}, {}, {},
              {"c_x": ("current_x", 1.0), "c_y": ("current_y", 1.0)}),),
        direction=("current_x", "current_y"),
    ),
    "pool_gyre": Effect(
        "the water circles", ("surge", "sway", "yaw"), (*PLACE, *TIME, *SPEED, *TURN), 0.01, 0.08,
        (_form("cell", "gyre", "wall_speed", 2**0.5),
         _form("Gaussian vortex", "gyre", gyre_law=_fixed(1), gyre_core_m=(0.5, 0.8)),
         _form("vortex with a core", "gyre", gyre_law=_fixed(2), gyre_core_m=(0.25, 0.5))),
        signed=True,
    ),
    "wall_effect": Effect(
        "drag near a wall", ("surge", "sway"), PLACE, 1.0, 12.0,
        (_form("exponential", "wall", wall_reach_m=(0.12, 0.2)),
         _form("inverse cube", "wall", wall_law=_fixed(1), wall_reach_m=(0.2, 0.35))),
    ),
    "stall": Effect(
        "lift lost at large angles", ("sway", "yaw"), TURN, 0.3, 0.9,
        (_form("logistic", "stall", stall_onset=(0.3, 0.5), stall_width=(0.1, 0.2)),
         _form("square of the excess", "stall", stall_law=_fixed(1), stall_onset=(0.25, 0.4),
               stall_width=(0.2, 0.3)),
         _form("cosine step", "stall", stall_law=_fixed(2), stall_onset=(0.3, 0.45),
               stall_width=(0.15, 0.3))),
    ),
    "servo_lag": Effect(
        "the head arrives late", ("sway", "yaw"), (*TIME, *TURN), 0.3, 1.2,
        (_form("first order", "servo_s", "time_constant"),
         _form("critically damped", "servo_s", servo_law=_fixed(1)),
         _form("limited rate", "servo_s", servo_law=_fixed(2))),
    ),
    "motor_spin_up": Effect(
        "the motor starts slowly", ("surge",), TIME, 0.4, 1.6,
        (_form("first order", "spin_s", "time_constant"),
         _form("tanh", "spin_s", spin_law=_fixed(1)),
         _form("ramp", "spin_s", spin_law=_fixed(2))),
    ),
    "battery_sag": Effect(
        "thrust sinks with time", ("surge",), TIME, 0.04, 0.14,
        (_form("linear", "sag_per_s", "loss_rate"),
         _form("hyperbola", "sag_per_s", sag_law=_fixed(1)),
         _form("exponential", "sag_per_s", sag_law=_fixed(2))),
    ),
    "trim_moment": Effect(
        "a moment on a straight robot", ("yaw",), (*SPEED, *TURN), 0.01, 0.08,
        (_form("square, on the head", "trim_kg"), _form("u|u|", "trim_kg", trim_law=_fixed(1))),
        signed=True,
    ),
    "head_angle_offset": Effect(
        "the head stands off its angle", ("sway", "yaw"), (*TURN, *SPEED), 0.03, 0.15,
        (_form("constant", "head_offset", "offset"),), signed=True,
    ),
    "crossflow_drag": Effect(
        "sideways drag of core and tail", ("sway", "yaw"), TURN, 0.8, 3.5,
        (_form("even depth", "cross", "drag_coefficient"),
         _form("tapering depth", "cross", cross_law=_fixed(1))),
    ),
    "thrust_line_offset": Effect(
        "thrust beside the centre of mass", ("yaw",), (*TURN, "flap_hz"), 0.006, 0.04,
        (_form("sine", "thrust_arm_m", "offset"),
         _form("angle", "thrust_arm_m", thrust_arm_law=_fixed(1))), signed=True,
    ),
    "thrust_area": Effect(
        "thrust does not grow with the head", ("surge",), (*LENGTH, *SPEED), 0.6, 1.3,
        (_form("share", "thrust_area", "missing_share"),),
    ),
    "lift_lag": Effect(
        "lift builds up with a delay", ("sway", "yaw"), (*TIME, *TURN), 0.5, 1.0,
        (_form("first order in lengths", "lag", "lagging_share", lag_lengths=(3.0, 8.0)),
         _form("Wagner, after Jones", "lag", lag_law=_fixed(1)),
         _form("fixed time", "lag", lag_law=_fixed(2), lag_lengths=(0.1, 0.3))),
    ),
    "wave_drag": Effect(
        "drag of waves", ("surge", "sway"), SPEED, 1.5, 20.0,
        (_form("v^4", "wave", "coefficient"), _form("v^6", "wave", wave_law=_fixed(1)),
         _form("Havelock's shape", "wave", wave_law=_fixed(2))),
    ),
    "coulomb_friction": Effect(
        "constant friction", ("surge", "sway"), SPEED, 0.03, 0.15,
        (_form("smooth", "coulomb_n", "F_c"), _form("tanh", "coulomb_n", coulomb_law=_fixed(1))),
    ),
    "wake_reentry": Effect(
        "drag changes in its own wake", ("surge", "sway"), TIME, 0.2, 0.45,
        (_form("logistic", "wake"), _form("linear", "wake", wake_law=_fixed(1))),
    ),
    "sinking": Effect(
        "drag grows as it sinks", ("surge", "sway"), TIME, 0.06, 0.4,
        (_form("linear", "sink_per_s", "drag_growth_rate"),
         _form("square", "sink_per_s", sink_law=_fixed(1))),
    ),
    "centre_of_mass_shift": Effect(
        "the centre of mass lies elsewhere", ("yaw",), TURN, 0.012, 0.05,
        (_form("ahead", "com_shift_m", "forward_shift"),), signed=True,
    ),
    "port_starboard_asymmetry": Effect(
        "lift differs between the sides", ("sway", "yaw"), TURN, 0.08, 0.4,
        (_form("step", "side", "lift_difference"),
         _form("tanh", "side", side_law=_fixed(1))), signed=True,
    ),
}  # fmt: skip

UNLISTED: Mapping[str, Effect] = {
    "tether": Effect(
        "an elastic cable pulls towards a peg", ("surge", "sway"), PLACE, 0.05, 0.5,
        (_form("spring", "tether_n_m", tether_x_m=(0.0, 2.6), tether_y_m=(0.0, 1.6)),),
    ),
    "drag_hump": Effect(
        "drag rises at one speed", ("surge", "sway"), SPEED, 0.3, 1.5,
        (_form("bump", "hump", hump_m_s=(0.3, 0.42), hump_width_m_s=(0.05, 0.08)),),
    ),
    "seiche": Effect(
        "the pool sloshes along its length", ("surge", "sway"), TIME, 0.01, 0.08,
        (_form("sine", "seiche_m_s", seiche_period_s=(2.2, 4.0)),), signed=True,
    ),
    "tail_jet": Effect(
        "the turned head bends the tail's jet sideways", ("sway",), (*TURN, "flap_hz"), 0.15, 1.5,
        (_form("sine", "jet"),), signed=True,
    ),
    "moment_wave": Effect(
        "the head's moment waves with the angle of attack", ("yaw",), TURN, 0.05, 0.4,
        (_form("sin 4 alpha", "moment_wave_m"),), signed=True,
    ),
}  # fmt: skip
