"""Laws of the drive: tail thrust, battery, motor, servo, and moments that come with the drive."""

from __future__ import annotations

import numpy as np

from .form import Array, Cause, Family, Quantity, Shape, Situation
from .robots import DEG, Robot


def _soft_step(x: Array) -> Array:
    """Logistic function, its argument limited to 60."""
    return 1 / (1 + np.exp(-np.clip(x, -60, 60)))


def _thrust_loss(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Thrust times 1 - s j, 1 - s j^2, exp(-s j), 1 - s (u/V0)^2, or a Strouhal window.

    j = (u/f) / (V0/f_max), the advance ratio over that of the straight run at full power; the
    window is centred at j = j_0.
    """
    robot = now.robot
    n = np.maximum(now.u, 0) / robot.top_speed
    flap = np.maximum(now.flap, 1e-3 * robot.top_flap)
    j = np.clip(n * robot.top_flap / flap, 0, 1.6)
    if cause.form == "linear":
        factor = 1 - strength * j
    elif cause.form == "quadratic":
        factor = 1 - strength * j**2
    elif cause.form == "exponential":
        factor = np.exp(-strength * j)
    elif cause.form == "speed_squared":
        factor = 1 - strength * n**2
    else:
        factor = 1 - strength * (1 - np.exp(-(((j - cause.shape["j_0"]) / 0.35) ** 2)))
    now.thrust = now.thrust * factor


def _draw_thrust_loss(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Advance ratio of the best thrust."""
    return {"j_0": round(rng.uniform(0.4, 0.75), 2)} if form == "strouhal_window" else {}


def _thrust_area(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Thrust that does not follow the area of the head: factor (1 - s) + s g of its length.

    g = h0/h, (h0/h)^(1/2), or 2/(1 + h/h0).
    """
    n = now.trials.head / now.robot.head_length
    factor = {"none": 1 / n, "sqrt_area": 1 / np.sqrt(n), "saturating": 2 / (1 + n)}[cause.form]
    now.thrust = now.thrust * (1 - strength + strength * factor)


def _sag(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Flapping frequency that falls with time; the strength is the share lost after 10 s.

    linear, exponential, hyperbolic, resistor-capacitor plus linear (Thevenin cell), or with the
    square of the frequency (load).
    """
    t = np.maximum(now.t, 0)
    tau = cause.shape.get("tau_s", 5.0)
    after_10_s = 1 - np.exp(-10 / tau)
    if cause.form == "linear":
        factor = 1 - strength * t / 10
    elif cause.form == "exponential":
        factor = 1 - strength * (1 - np.exp(-t / tau)) / after_10_s
    elif cause.form == "hyperbolic":
        factor = 1 / (1 + strength / (1 - strength) * t / 10)
    elif cause.form == "rc_linear":
        settled = 0.5 * (1 - np.exp(-t / tau)) / after_10_s
        factor = 1 - strength * (0.5 * t / 10 + settled)
    else:
        factor = 1 - strength * t / 10 * (now.trials.flap / now.robot.top_flap) ** 2
    now.flap = now.flap * np.maximum(factor, 0.3)


def _draw_sag(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Time constant of the fall."""
    if form in ("exponential", "rc_linear"):
        return {"tau_s": round(rng.uniform(2.5, 8), 2)}
    return {}


def _spin_up(now: Situation, strength: Quantity, cause: Cause) -> None:
    """The motor needs about `strength` seconds (time constant, ramp or dead time) to start."""
    t, seconds = np.maximum(now.t, 0), np.maximum(strength, 1e-3)
    n = t / seconds
    if cause.form == "first_order":
        factor = 1 - np.exp(-n)
    elif cause.form == "second_order":
        factor = 1 - (1 + n) * np.exp(-n)
    elif cause.form == "ramp":
        factor = np.minimum(n, 1)
    elif cause.form == "s_curve":
        factor = np.minimum(n, 1) ** 2 * (3 - 2 * np.minimum(n, 1))
    else:
        factor = _soft_step((t - seconds) / 0.04)
    now.flap = now.flap * factor


def _servo_lag(now: Situation, strength: Quantity, cause: Cause) -> None:
    """The head reaches its angle late: first order, underdamped, rate limit, or dead time.

    strength: time constant, s; for the rate limit the time for 30 deg; for the dead time its
    length.
    """
    t, seconds = np.maximum(now.t, 0), np.maximum(strength, 1e-3)
    n = t / seconds
    if cause.form == "underdamped":
        damping = cause.shape["damping"]
        rate = np.sqrt(1 - damping * damping)
        swing = np.cos(rate * n) + damping / rate * np.sin(rate * n)
        reached = 1 - np.exp(-damping * n) * swing
    elif cause.form == "rate_limit":
        reached = np.minimum(n * 30 * DEG / np.maximum(np.abs(now.trials.phi), 1e-6), 1)
    elif cause.form == "dead_time":
        reached = _soft_step((t - seconds) / 0.05)
    else:
        reached = 1 - np.exp(-n)
    now.phi = now.phi - now.trials.phi * (1 - reached)


def _draw_servo_lag(rng: np.random.Generator, _robot: Robot, form: str) -> Shape:
    """Damping ratio of the second-order lag."""
    return {"damping": round(rng.uniform(0.15, 0.5), 2)} if form == "underdamped" else {}


def _head_offset(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Lasting difference of the head angle: constant, lost play against its sign, or a gain."""
    wanted = now.trials.phi
    if cause.form == "constant":
        change = strength + 0 * wanted
    elif cause.form == "backlash":
        change = -strength * np.tanh(wanted / 0.01)
    else:
        change = strength * wanted
    now.phi = now.phi + change


def _trim(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Turning moment s (V/V0)^2, s u|u|/V0^2, s T/T0, or s while the motor runs."""
    top = now.robot.top_speed
    if cause.form == "speed_squared":
        factor = (now.speed / top) ** 2
    elif cause.form == "u_abs_u":
        factor = now.u * np.abs(now.u) / top**2
    elif cause.form == "thrust":
        factor = now.thrust / now.robot.top_thrust
    else:
        factor = (now.flap > 0) * 1.0
    now.moment = now.moment + strength * factor


def _thrust_line(now: Situation, strength: Quantity, cause: Cause) -> None:
    """Thrust passes the centre of mass `strength` g(phi) m to port: sin(phi), phi, sin(2 phi)."""
    phi = now.phi
    share = {"sin": np.sin(phi), "linear": phi, "sin_2": np.sin(2 * phi)}[cause.form]
    now.moment = now.moment - now.thrust * strength * share


FAMILIES = (
    Family(
        "thrust_loss_with_speed", {"thrust": _thrust_loss},
        ("linear", "quadratic", "exponential", "speed_squared", "strouhal_window"),
        channels=("surge",), variable="u/f", unit="-", scale="1", span=(0.03, 0.7),
        draw=_draw_thrust_loss,
    ),
    Family(
        "thrust_area", {"thrust": _thrust_area}, ("none", "sqrt_area", "saturating"),
        channels=("surge",), variable="head length", unit="-", scale="1", span=(0.1, 1.0),
    ),
    Family(
        "battery_sag", {"motor": _sag},
        ("linear", "exponential", "hyperbolic", "rc_linear", "load"),
        channels=("surge",), variable="t", unit="-", scale="1", span=(0.005, 0.2), draw=_draw_sag,
    ),
    Family(
        "motor_spin_up", {"motor": _spin_up},
        ("first_order", "second_order", "ramp", "s_curve", "dead_time"),
        channels=("surge",), variable="t", unit="s", scale="s", span=(0.03, 2.5),
    ),
    Family(
        "servo_lag", {"servo": _servo_lag},
        ("first_order", "underdamped", "rate_limit", "dead_time"),
        channels=("sway", "yaw"), variable="t, phi", unit="s", scale="s", span=(0.08, 0.8),
        seen=True, draw=_draw_servo_lag,
    ),
    Family(
        "head_angle_offset", {"servo": _head_offset}, ("constant", "backlash", "gain"),
        channels=("sway", "yaw"), variable="phi",
        unit={"constant": "rad", "backlash": "rad", "gain": "-"},
        scale="1", span=(0.008, 0.14), signed=("constant", "gain"), parity={"constant": "odd"},
    ),
    Family(
        "trim_moment", {"load": _trim}, ("speed_squared", "u_abs_u", "thrust", "constant"),
        channels=("yaw",), variable="V", unit="N m", scale="TL", span=(0.001, 0.09),
        parity="odd", signed=True,
    ),
    Family(
        "thrust_line_offset", {"load": _thrust_line}, ("sin", "linear", "sin_2"),
        channels=("yaw",), variable="phi", unit="m", scale="L", span=(0.004, 0.12), signed=True,
    ),
)  # fmt: skip
