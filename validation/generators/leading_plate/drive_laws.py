"""Laws of the drive: frequency over time, thrust over speed and head, servo of the head."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .here import Family, Here, Law, Setting
from .robots import Array

LONGEST = 12.0
"""Time at which a sag has its stated size (s)."""


def drive_factor(laws: Sequence[Law], time: Array, setting: Setting) -> Array:
    """Frequency over its steady value, `time` seconds after the release."""
    factor = np.ones_like(time)
    for law in laws:
        if law.name == "motor_spin_up":
            factor = factor * _spin_up(law, time)
        elif law.name == "battery_sag":
            factor = factor * (1 - law.size * _discharge(law, time, setting))
    return factor


def _spin_up(law: Law, time: Array) -> Array:
    x = time / law.size
    if law.form == "second_order":
        return 1 - (1 + 2 * x) * np.exp(-2 * x)
    if law.form == "s_curve":
        part = np.clip(x / 2.5, 0, 1)
        return part**2 * (3 - 2 * part)
    return 1 - np.exp(-x)


def _discharge(law: Law, time: Array, setting: Setting) -> Array:
    """1 after `LONGEST` at full power."""
    if law.form == "charge":  # in proportion to the charge drawn, hence to the cube of frequency
        return time / LONGEST * (setting.flap / setting.full) ** 3
    if law.form == "exponential":
        settling = LONGEST * (0.15 + 0.35 * law.shape[0])
        return (1 - np.exp(-time / settling)) / (1 - np.exp(-LONGEST / settling))
    return time / LONGEST * (1 + law.shape[0] * time / LONGEST) / (1 + law.shape[0])


def _nothing(law: Law, here: Here) -> None:
    """The frequency already contains it (`drive_factor`)."""


def _thrust_loss(law: Law, here: Here) -> None:
    setting, robot = here.setting, here.robot
    advance = np.maximum(here.core.real, 0) / setting.flap / (robot.speed / robot.flap)
    if law.form == "quadratic":
        share = law.size * advance**2
    elif law.form == "exponential":
        share = 1 - np.exp(-law.size * advance**1.3)
    else:
        share = law.size * advance
    here.thrust = here.thrust * (1 - np.minimum(share, 0.95))


def _thrust_area(law: Law, here: Here) -> None:
    ratio = here.setting.head / here.robot.head_length
    if law.form == "power":
        here.thrust = here.thrust * ratio**-law.size
    else:
        here.thrust = here.thrust * (1 - law.size * (ratio - 1) / ratio)


def _wake(law: Law, here: Here) -> None:
    rounds = here.turned / (2 * np.pi)
    if law.form == "ramp":
        entered = np.clip(rounds - 0.9, 0, 1.5)
    elif law.form == "saturating":
        entered = 1 - np.exp(-np.maximum(rounds - 0.9, 0) / 0.25)
    else:
        entered = 0.5 + 0.5 * np.tanh((rounds - 1.0) / 0.08)
    here.thrust = here.thrust * (1 - np.minimum(law.size * entered, 0.9))


def head_angle(law: Law, here_phi: Array, time: Array, servo_sides: Array) -> Array:
    """Head angle after a law of the servo. servo_sides: commanded angle (rad)."""
    if law.name == "head_angle_offset":
        if law.form == "with_gain":
            return here_phi + law.side * law.size * (0.75 + 0.5 * np.abs(servo_sides) / 0.6)
        return here_phi + law.side * law.size
    x = time / law.size
    if law.form == "second_order":
        return here_phi * (1 - (1 + 1.7 * x) * np.exp(-1.7 * x))
    if law.form == "rate_limit":  # a constant rate, the same for all angles, rounded at the end
        reach = np.maximum(np.abs(here_phi), 1e-6)
        return here_phi * np.tanh(0.6 * time / law.size / reach)
    return here_phi * (1 - np.exp(-x))


def _servo(law: Law, here: Here) -> None:
    here.phi = head_angle(law, here.phi, here.time, here.setting.phi)


DRIVE_FAMILIES = (
    Family("motor_spin_up", "input", _nothing, ("first_order", "second_order", "s_curve"),
           0.03, 2.0, "s", "time constant", 0.2),
    Family("battery_sag", "input", _nothing, ("linear", "exponential", "charge"),
           0.005, 0.3, "1", "share of frequency lost after 12 s", 0.02),
    Family("thrust_loss_with_speed", "load", _thrust_loss, ("linear", "quadratic", "exponential"),
           0.03, 0.65, "1", "share of thrust lost at full speed", 0.1),
    Family("thrust_area", "load", _thrust_area, ("power", "partial"),
           0.05, 1.2, "1", "exponent or share that thrust lacks over head area", 0.2),
    Family("wake_reentry", "load", _wake, ("logistic", "ramp", "saturating"),
           0.03, 0.5, "1", "share of thrust lost after a round", 0.1),
    Family("servo_lag", "input", _servo, ("first_order", "second_order", "rate_limit"),
           0.04, 1.6, "s", "time constant", 0.2),
    Family("head_angle_offset", "input", _servo, ("constant", "with_gain"),
           0.004, 0.12, "rad", "offset of the head", 0.01),
)  # fmt: skip
