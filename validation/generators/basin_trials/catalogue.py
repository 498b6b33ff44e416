"""All laws that can be hidden, with their forms and sizes."""

from __future__ import annotations

import numpy as np

from . import body_laws, drive_laws, head_laws, unlisted_laws, water
from .form import Family, HiddenLaw

INPUT, WATER, HEAD, BODY = "input", "water", "head", "body"
"""Stages of a moment, in this order."""

_FAMILIES = (
    Family("motor_spin_up", INPUT, drive_laws.motor_spin_up,
           ("weibull", "gompertz", "current_limited"), "rise_time", "s", 0.5, 1.8),
    Family("battery_sag", INPUT, drive_laws.battery_sag,
           ("shepherd", "relaxing", "load", "late"), "thrust_loss_at_5_s", "1", 0.1, 0.5),
    Family("servo_lag", INPUT, drive_laws.servo_lag,
           ("quintic", "second_order", "slew_rate"), "motion_time", "s", 0.5, 1.8),
    Family("head_angle_offset", INPUT, drive_laws.head_angle_offset,
           ("constant", "bent_horn", "uneven_play"), "offset", "rad", 0.02, 0.12, signed=True),
    Family("uniform_current", WATER, water.uniform_current,
           ("steady", "running_down", "poiseuille"), "speed", "m/s", 0.01, 0.06),
    Family("pool_gyre", WATER, water.pool_gyre,
           ("lamb_oseen", "vatistas", "shallow_basin"), "largest_speed", "m/s", 0.01, 0.07,
           signed=True),
    Family("stall", HEAD, head_laws.stall,
           ("hill", "beddoes", "hill_and_moment"), "lift_loss", "1", 0.3, 0.85),
    Family("lift_lag", HEAD, head_laws.lift_lag,
           ("coefficient", "circulation", "fixed_time"), "lagging_share", "1", 0.5, 1.0),
    Family("port_starboard_asymmetry", HEAD, head_laws.port_starboard_asymmetry,
           ("tanh", "proportional", "with_drag"), "lift_difference", "1", 0.05, 0.4, signed=True),
    Family("thrust_loss_with_speed", HEAD, head_laws.thrust_loss_with_speed,
           ("logistic", "rational", "gaussian"), "thrust_loss", "1", 0.3, 0.8),
    Family("thrust_area", HEAD, head_laws.thrust_area,
           ("power", "rational"), "exponent", "1", 0.4, 1.3),
    Family("centre_of_mass_shift", HEAD, head_laws.centre_of_mass_shift,
           ("fixed", "with_cap"), "shift_to_head", "m", 0.008, 0.03, signed=True),
    Family("viscous_drag", BODY, body_laws.viscous_drag,
           ("linear", "abraham", "power_1.25"), "force_at_0.3_m_s", "N", 0.03, 0.3),
    Family("wave_drag", BODY, body_laws.wave_drag,
           ("lamb_cylinder", "fifth_power", "kelvin_onset"), "force_at_0.4_m_s", "N", 0.05, 0.5),
    Family("coulomb_friction", BODY, body_laws.coulomb_friction,
           ("arctan", "hyperbolic", "lorentz_stribeck"), "force", "N", 0.01, 0.12),
    Family("linear_yaw_damping", BODY, body_laws.linear_yaw_damping,
           ("plain", "saturating", "power_1.25"), "moment_at_1_rad_s", "N m", 0.004, 0.06),
    Family("crossflow_drag", BODY, body_laws.crossflow_drag,
           ("elliptic", "wedge", "low_reynolds"), "drag_coefficient", "1", 0.5, 3.0),
    Family("added_mass", BODY, body_laws.added_mass,
           ("prolate", "skewed_plate", "partial_munk"), "sway_mass_over_mass", "1", 0.3, 1.2),
    Family("trim_moment", BODY, body_laws.trim_moment,
           ("speed_times_rate", "power_1.5", "idle_and_thrust"), "moment", "N m", 0.0006, 0.01,
           signed=True),
    Family("thrust_line_offset", BODY, body_laws.thrust_line_offset,
           ("tan_half", "quadratic"), "offset", "m", 0.004, 0.03, signed=True),
    Family("wall_effect", BODY, water.wall_effect,
           ("sech2", "power_2.5", "suction"), "drag_share", "1", 0.8, 10.0),
    Family("wake_reentry", BODY, body_laws.wake_reentry,
           ("gaussian", "rational"), "drag_loss", "1", 0.25, 0.9),
    Family("sinking", BODY, body_laws.sinking,
           ("steady", "terminal", "relaxing"), "rate", "m/s", 0.006, 0.035),
    Family("compass", BODY, unlisted_laws.compass,
           ("two_fold",), "moment", "N m", 0.001, 0.02, where=("yaw", "heading_rad")),
    Family("curtain", BODY, unlisted_laws.curtain,
           ("gaussian",), "force", "N", 0.02, 0.4, where=("surge", "x_m")),
    Family("hunting", BODY, unlisted_laws.hunting,
           ("triangle",), "moment", "N m", 0.001, 0.02, where=("yaw", "time_s")),
    Family("snag", BODY, unlisted_laws.snag,
           ("raised_cosine",), "force", "N", 0.02, 0.4, where=("surge", "time_s")),
    Family("pitch_up", BODY, unlisted_laws.pitch_up,
           ("power_1.5",), "force_at_1_rad_s", "N", 0.02, 0.4, where=("surge", "yaw_rate_rad_s")),
)  # fmt: skip
FAMILIES = {family.name: family for family in _FAMILIES}
CAUSES = tuple(family.name for family in _FAMILIES if family.where is None)
UNLISTED = tuple(family.name for family in _FAMILIES if family.where is not None)
PLACE_DEPENDENT = ("uniform_current", "pool_gyre", "wall_effect", "compass", "curtain")
"""Laws whose size depends on where the trials start."""


def draw_law(rng: np.random.Generator, name: str) -> HiddenLaw:
    """A law of this name with a drawn form and shape, and its first size."""
    family = FAMILIES[name]
    sign = -1 if family.signed and rng.random() < 0.5 else 1
    form, shape = str(rng.choice(family.forms)), tuple(float(s) for s in rng.random(3))
    return HiddenLaw(family, form, shape, sign * family.start)
