"""Forms that act on the drive (flapping frequency, thrust), on the servo and through the water.

Stages: `drive` returns a factor on the frequency, `thrust` a factor on the thrust, `servo` the
head angle from the commanded one, `water` the water's velocity as a complex number. Sources:
Carlton (thrust against advance ratio), Triantafyllou (1993, Strouhal window), Shepherd (1965,
battery discharge), Scully (1975) and Lamb-Oseen for vortices.
"""

import numpy as np

from .form import Form, family


def _advance(s):
    """Advance ratio u / (f L) over that of the straight robot."""
    return np.maximum(s.u, 0) / (s.frequency + 1e-3) * s.b.flap / s.b.speed_ref


def _strouhal(s, p):
    """Thrust falls away from the best Strouhal number, here as a ratio to the straight run's."""
    strouhal = 1 / (_advance(s) + 0.2)
    return 1 - p.amp * (1 - np.exp(-(((np.log(strouhal) - p.best) / 0.5) ** 2)))


_THRUST_LOSS = {
    "linear": lambda s, p: 1 - p.amp * _advance(s),
    "quadratic": lambda s, p: 1 - p.amp * _advance(s) ** 2,
    "exponential": lambda s, p: np.exp(-p.amp * _advance(s)),
    "speed_squared": lambda s, p: 1 - p.amp * (s.u / s.b.speed_ref) ** 2,
    "strouhal_window": (_strouhal, {"best": (-0.6, -0.1, "ln of relative Strouhal number")}),
}
THRUST_LOSS = family(
    "thrust_loss_with_speed",
    "thrust",
    ("loss", "1 at the straight run's advance ratio", lambda _b: 0.7),
    _THRUST_LOSS,
)

_SHARE = {"magnitude": ("share", "1", lambda _b: 1.0)}
_AREA = {
    "power": lambda s, p: (s.b.head / s.head) ** p.amp,
    "none": (lambda s, p: 1 - p.amp * (1 - s.b.head / s.head), {}, _SHARE),
    "sqrt": (lambda s, p: 1 - p.amp * (1 - np.sqrt(s.b.head / s.head)), {}, _SHARE),
}
AREA = family("thrust_area", "thrust", ("exponent", "1", lambda _b: 1.0), _AREA)


def _curve(shape):
    return lambda s, p: 1 - p.amp * shape(s, p)


_SAG = {
    "linear": _curve(lambda s, _p: s.t / 10),
    "exponential": (_curve(lambda s, p: 1 - np.exp(-s.t / p.tau)), {"tau": (2.0, 6.0, "s")}),
    "hyperbolic": lambda s, p: 1 / (1 + p.amp * s.t / 10),
    "rc_plus_linear": (
        _curve(lambda s, p: 0.5 * (1 - np.exp(-s.t / p.tau)) + 0.05 * s.t),
        {"tau": (0.8, 2.5, "s")},
    ),
    "load_dependent": _curve(lambda s, _p: s.power**2 * s.t / 10),
}
SAG = family("battery_sag", "drive", ("sag", "1 in 10 s", lambda _b: 0.3), _SAG)


def _smoothstep(x):
    x = np.clip(x, 0, 1)
    return x * x * (3 - 2 * x)


def _rise(s, p):
    return s.t / (p.amp + 1e-3)


_SPIN_UP = {
    "first_order": lambda s, p: 1 - np.exp(-_rise(s, p)),
    "second_order": lambda s, p: 1 - (1 + _rise(s, p)) * np.exp(-_rise(s, p)),
    "ramp": lambda s, p: np.clip(_rise(s, p) / 2, 0, 1),
    "s_curve": lambda s, p: _smoothstep(_rise(s, p) / 2),
    "dead_time": lambda s, p: 0.5 * (1 + np.tanh((s.t - p.amp) / 0.03)),
}
SPIN_UP = family("motor_spin_up", "drive", ("tau", "s", lambda _b: 1.5), _SPIN_UP)


def _underdamped(s, phi, p):
    x = _rise(s, p)
    root = np.sqrt(1 - p.damping**2)
    swing = np.cos(root * x) + p.damping / root * np.sin(root * x)
    return phi * (1 - np.exp(-p.damping * x) * swing)


_SERVO = {
    "first_order": lambda s, phi, p: phi * (1 - np.exp(-_rise(s, p))),
    "second_order": lambda s, phi, p: phi * (1 - (1 + _rise(s, p)) * np.exp(-_rise(s, p))),
    "underdamped": (_underdamped, {"damping": (0.3, 0.6, "1")}),
    "rate_limit": (
        lambda s, phi, p: np.sign(phi) * np.minimum(np.abs(phi), 0.5 * _rise(s, p)),
        {},
        {"magnitude": ("tau_half_radian", "s", lambda _b: 2.5)},
    ),
    "dead_time": lambda s, phi, p: phi * 0.5 * (1 + np.tanh((s.t - p.amp) / 0.03)),
}
SERVO = family("servo_lag", "servo", ("tau", "s", lambda _b: 1.5), _SERVO)

_HEAD_OFFSET = {
    "constant": lambda _s, phi, p: phi + p.amp,
    "backlash": lambda _s, phi, p: phi - p.amp * np.tanh(phi / 0.02),
    "gain": (
        lambda _s, phi, p: phi * (1 + p.amp),
        {},
        {"magnitude": ("gain_error", "1", lambda _b: 0.25)},
    ),
}
HEAD_OFFSET = family(
    "head_angle_offset", "servo", ("offset", "rad", lambda _b: 0.1), _HEAD_OFFSET, signed=True
)


def _session(s):
    """Position of the trial in the session, 0 to 1."""
    return s.trial / max(s.trials - 1, 1)


def _place(s):
    """Position from the pool's centre in half lengths and half widths."""
    length, width, _ = s.b.pool
    return 2 * s.x / length - 1, 2 * s.y / width - 1


_DIRECTION = {"direction": (0.0, 6.283, "rad")}
_CURRENT = {
    "constant": (lambda s, p: p.amp * np.exp(1j * p.direction) + 0 * s.x, _DIRECTION),
    "drifting": (
        lambda s, p: p.amp * np.exp(1j * (p.direction + p.veer * _session(s))),
        {**_DIRECTION, "veer": (-2.0, 2.0, "rad per session")},
    ),
    "sheared": (
        lambda s, p: p.amp * (1 + p.shear * _place(s)[1]) + 0j,
        {"shear": (0.5, 1.5, "per half width")},
    ),
}
CURRENT = family(
    "uniform_current", "water", ("speed", "m/s", lambda b: 0.15 * b.speed_ref), _CURRENT
)


def _cells(s, p, number):
    length, width, _ = s.b.pool
    a, b = number * np.pi * s.x / length, np.pi * s.y / width
    u = np.sin(a) * np.cos(b) / width
    v = -number * np.cos(a) * np.sin(b) / length
    return p.amp * (u + 1j * v) * width


def _vortex(s, p, profile):
    """Swirl about (x0, y0); profile(d) peaks at 1 for d = distance over core radius."""
    length, width, _ = s.b.pool
    offset = (s.x - p.x0 * length) + 1j * (s.y - p.y0 * width)
    distance = np.abs(offset) + 1e-9
    return 1j * p.amp * offset / distance * profile(distance / (p.radius * width))


_CORE = {"x0": (0.35, 0.65, "pool L"), "y0": (0.35, 0.65, "pool W"), "radius": (0.2, 0.4, "pool W")}
_GYRE = {
    "cell": lambda s, p: _cells(s, p, 1),
    "two_cells": lambda s, p: _cells(s, p, 2),
    "solid_body": (lambda s, p: _vortex(s, p, lambda d: d / 2), _CORE),
    "gaussian": (lambda s, p: _vortex(s, p, lambda d: 1.566 * (1 - np.exp(-(d**2))) / d), _CORE),
    "scully": (lambda s, p: _vortex(s, p, lambda d: 2 * d / (1 + d**2)), _CORE),
}
GYRE = family(
    "pool_gyre", "water", ("speed", "m/s", lambda b: 0.15 * b.speed_ref), _GYRE, signed=True
)

_THRUST_AND_SERVO = [*THRUST_LOSS, *AREA, *SAG, *SPIN_UP, *SERVO, *HEAD_OFFSET]
DRIVE_FORMS: list[Form] = [*_THRUST_AND_SERVO, *CURRENT, *GYRE]
