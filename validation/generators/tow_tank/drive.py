"""Motor, servo and thrust. A law returns a factor, or the head angle (servo)."""

from __future__ import annotations

from typing import Any

import numpy as np

from .form import Form, Shape, forms
from .motion import Flow


def _delayed_time(t: Any) -> Any:
    return np.maximum(t, 0.0)


def _second_order(t: Any, tau: float, zeta: float) -> Any:
    """Step response with undamped time tau and damping zeta < 1."""
    w, s = 1 / tau, np.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * w * _delayed_time(t))
    return 1 - decay * (
        np.cos(w * s * _delayed_time(t)) + zeta / s * np.sin(w * s * _delayed_time(t))
    )


def _critically_damped(t: Any, tau: float) -> Any:
    x = _delayed_time(t) / (0.5 * tau)
    return 1 - (1 + x) * np.exp(-x)


def _s_curve(t: Any, tau: float) -> Any:
    x = np.clip(t / (2.5 * tau), 0, 1)
    return x * x * (3 - 2 * x)


def _dead_time(t: Any, tau: float) -> Any:
    return 1 - np.exp(-_delayed_time(t - 0.4 * tau) / (0.6 * tau))


def _rate_limit(c: Flow, k: float, _: Shape) -> Any:
    # k is the time for half a radian
    target = c.lanes.head_angle + c.lanes.servo_error
    return np.sign(target) * np.minimum(np.abs(target), 0.5 * _delayed_time(c.t) / k)


def _servo(response: Any) -> Any:
    return lambda c, k, p: (c.lanes.head_angle + c.lanes.servo_error) * response(c.t, k, p)


def _advance_ratio(c: Flow) -> Any:
    return np.maximum(c.u, 0) / (c.f * 0.08)  # J with a beat of 8 cm


def _load_dependent_sag(c: Flow, k: float, _: Shape) -> Any:
    return 1 - k * (c.lanes.flap / 5.0) ** 2 * _delayed_time(c.t) / 8


def _head_area_ratio(c: Flow) -> Any:
    return c.lanes.head / c.robot.head_length


def _offset(name: str) -> Any:
    def law(c: Flow, k: float, _: Shape) -> Any:
        target, delta = c.lanes.head_angle, np.deg2rad(k)
        more = {"constant": 1.0, "gain": target / 0.5, "backlash": -np.sign(target)}[name]
        return target + c.lanes.servo_error + delta * more

    return law


FORMS: list[Form] = [
    *forms(
        "motor_spin_up",
        "shaft",
        0.02,
        1.5,
        "s",
        "surge",
        {
            "first order": lambda c, k, _: 1 - np.exp(-_delayed_time(c.t) / k),
            "second order": lambda c, k, _: _critically_damped(c.t, k),
            "ramp": lambda c, k, _: np.clip(c.t / (2 * k), 0, 1),
            "s-curve": lambda c, k, _: _s_curve(c.t, k),
        },
    ),
    *forms(
        "battery_sag",
        "shaft",
        0.001,
        0.35,
        "share in 8 s",
        "surge",
        {
            "linear": lambda c, k, _: 1 - k * _delayed_time(c.t) / 8,
            "exponential": (
                lambda c, k, p: 1 - k * (1 - np.exp(-_delayed_time(c.t) / p["time"])),
                {"time": (1.5, 5.0)},
            ),
            "rc": (
                lambda c, k, p: (
                    1 - k * (0.5 * (1 - np.exp(-_delayed_time(c.t) / p["time"])) + c.t / 16)
                ),
                {"time": (0.4, 1.5)},
            ),
            "load": _load_dependent_sag,
        },
    ),
    *forms(
        "servo_lag",
        "servo",
        0.01,
        2.0,
        "s",
        "sway yaw",
        {
            "first order": _servo(lambda t, k, _: 1 - np.exp(-_delayed_time(t) / k)),
            "underdamped": (
                _servo(lambda t, k, p: _second_order(t, k, p["zeta"])),
                {"zeta": (0.35, 0.8)},
            ),
            "dead time": _servo(lambda t, k, _: _dead_time(t, k)),
            "rate limit": _rate_limit,
        },
    ),
    *forms(
        "head_angle_offset",
        "servo",
        0.1,
        6.0,
        "deg",
        "sway yaw",
        {
            "constant": _offset("constant"),
            "gain": _offset("gain"),
            "backlash": _offset("backlash"),
        },
        signed=True,
    ),
    *forms(
        "thrust_loss_with_speed",
        "thrust",
        0.004,
        0.5,
        "",
        "surge",
        {
            "linear": lambda c, k, _: np.maximum(1 - k * _advance_ratio(c), 0),
            "square": lambda c, k, _: np.maximum(1 - k * _advance_ratio(c) ** 2, 0),
            "exponential": lambda c, k, _: np.exp(-k * _advance_ratio(c)),
            "speed alone": lambda c, k, _: np.maximum(1 - k * (np.maximum(c.u, 0) / 0.4) ** 2, 0),
        },
    ),
    *forms(
        "thrust_area",
        "thrust",
        0.05,
        1.2,
        "",
        "surge",
        {
            "power": lambda c, k, _: _head_area_ratio(c) ** -k,
            "blend": lambda c, k, _: 1 - k * (1 - 1 / _head_area_ratio(c)),
            "logarithm": lambda c, k, _: 1 - k * np.log(_head_area_ratio(c)),
        },
    ),
    *forms(
        "unexplained",
        "thrust",
        0.005,
        0.6,
        "",
        "surge",
        {
            "resonance": (
                lambda c, k, p: 1 + k * np.exp(-(((c.f - p["f"]) / p["width"]) ** 2)),
                {"f": (3.0, 4.6), "width": (0.5, 0.9)},
            ),
        },
        signed=True,
        variable="flap_hz",
    ),
]
