"""Motor and servo in the first seconds, the battery, and a robot that sinks."""

# ruff: noqa: ARG001 - laws of one stage share their arguments

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .form import Form, form_maker
from .robots import ParallelTrials

Array = NDArray[np.float64]
ShapeParameters = Any
REFERENCE_DURATION_S = 8.0
"""Duration, s, after which the laws of the battery and of sinking reach their strength."""


def _as_column(t: Array | float) -> Array:
    """Times as a last axis of one lane; a single time as it is."""
    t = np.asarray(t, float)
    return t[:, None] if t.ndim else t


def spin_up_first_order(t: Array, lanes: ParallelTrials, s: Array, p: ShapeParameters) -> Array:
    """1 - s exp(-t/tau): motor with inertia."""
    return 1 - s * np.exp(-_as_column(t) / p["tau_s"])


def spin_up_critically_damped(
    t: Array, lanes: ParallelTrials, s: Array, p: ShapeParameters
) -> Array:
    """1 - s (1 + t/tau) exp(-t/tau): critically damped, inertia and inductance."""
    x = 1.7 * _as_column(t) / p["tau_s"]
    return 1 - s * (1 + x) * np.exp(-x)


def spin_up_ramp(t: Array, lanes: ParallelTrials, s: Array, p: ShapeParameters) -> Array:
    """A speed controller's ramp over 2 tau."""
    return 1 - s * np.maximum(1 - _as_column(t) / (2 * p["tau_s"]), 0)


def spin_up_s_curve(t: Array, lanes: ParallelTrials, s: Array, p: ShapeParameters) -> Array:
    """S-curve of a jerk-limited controller over 2 tau."""
    x = np.clip(_as_column(t) / (2 * p["tau_s"]), 0, 1)
    return 1 - s * (1 - x**2 * (3 - 2 * x))


def sag_linear(t: Array, lanes: ParallelTrials, s: Array, p: ShapeParameters) -> Array:
    """1 - s t/8 s."""
    return 1 - s * _as_column(t) / REFERENCE_DURATION_S


def sag_exponential(t: Array, lanes: ParallelTrials, s: Array, p: ShapeParameters) -> Array:
    """1 - s (1 - exp(-t/tau)): an RC branch of the battery (Chen and Rincon-Mora 2006)."""
    return 1 - s * (1 - np.exp(-_as_column(t) / p["tau_s"]))


def sag_hyperbolic(t: Array, lanes: ParallelTrials, s: Array, p: ShapeParameters) -> Array:
    """1/(1 + s t/8 s)."""
    return 1 / (1 + s * _as_column(t) / REFERENCE_DURATION_S)


def sag_thevenin(t: Array, lanes: ParallelTrials, s: Array, p: ShapeParameters) -> Array:
    """Half an RC branch, half linear (Thevenin battery that is emptied)."""
    return 1 - s / 2 * (
        1 - np.exp(-_as_column(t) / p["tau_s"]) + _as_column(t) / REFERENCE_DURATION_S
    )


def sag_load_dependent(t: Array, lanes: ParallelTrials, s: Array, p: ShapeParameters) -> Array:
    """Linear, as the square of the frequency (s at 5.82 Hz): load on the inner resistance."""
    return 1 - s * (lanes.flap / 5.82) ** 2 * _as_column(t) / REFERENCE_DURATION_S


def servo_first_order(t: Array, phi: Array, s: Array, p: ShapeParameters) -> tuple[Array, Array]:
    """A share s of the angle is still to come at the start: phi (1 - s exp(-t/tau))."""
    rest = s * np.exp(-_as_column(t) / p["tau_s"])
    return phi * (1 - rest), phi * rest / p["tau_s"]


def servo_underdamped(t: Array, phi: Array, s: Array, p: ShapeParameters) -> tuple[Array, Array]:
    """Underdamped: exp(-d w t) cos(w_d t) and its sine, from a servo at rest."""
    damping, omega = 0.35, 1.5 / p["tau_s"]
    w_d = omega * np.sqrt(1 - damping**2)
    t = _as_column(t)
    fall = s * np.exp(-damping * omega * t)
    rest = fall * (np.cos(w_d * t) + damping * omega / w_d * np.sin(w_d * t))
    return phi * (1 - rest), phi * fall * omega**2 / w_d * np.sin(w_d * t)


def servo_rate_limited(t: Array, phi: Array, s: Array, p: ShapeParameters) -> tuple[Array, Array]:
    """Rate limit: the rest is covered evenly in 2 tau."""
    end = 2 * p["tau_s"]
    t = _as_column(t)
    return phi * (1 - s * np.maximum(1 - t / end, 0)), phi * s / end * (t < end)


def servo_dead_time(t: Array, phi: Array, s: Array, p: ShapeParameters) -> tuple[Array, Array]:
    """First order after a dead time of `dead_s`."""
    late = np.maximum(_as_column(t) - p["dead_s"], 0)
    rest = s * np.exp(-late / p["tau_s"])
    return phi * (1 - rest), phi * rest / p["tau_s"] * (late > 0)


def sinking_linear(t: Array, s: Array, p: ShapeParameters) -> Array:
    """Depth gained, m: s t/8 s."""
    return s * _as_column(t) / REFERENCE_DURATION_S


def sinking_quadratic(t: Array, s: Array, p: ShapeParameters) -> Array:
    """S (t/8 s)^2: constant lack of buoyancy."""
    return s * (_as_column(t) / REFERENCE_DURATION_S) ** 2


def sinking_saturating(t: Array, s: Array, p: ShapeParameters) -> Array:
    """S (1 - exp(-t/tau))."""
    return s * (1 - np.exp(-_as_column(t) / p["tau_s"]))


_spin = form_maker("motor_spin_up", "drive", "1")
_sag = form_maker("battery_sag", "drive", "1")
_servo = form_maker("servo_lag", "servo", "1", ("sway", "yaw"))
_sink = form_maker("sinking", "sink", "m")
TAU = (0.25, 0.7)
FORMS: tuple[Form, ...] = (
    _spin("first_order", spin_up_first_order, 1e-3, 0.95, tau_s=TAU),
    _spin("second_order", spin_up_critically_damped, 1e-3, 0.95, tau_s=TAU),
    _spin("ramp", spin_up_ramp, 1e-3, 0.95, tau_s=TAU),
    _spin("s_curve", spin_up_s_curve, 1e-3, 0.95, tau_s=TAU),
    _sag("linear", sag_linear, 1e-3, 0.5),
    _sag("exponential", sag_exponential, 1e-3, 0.5, tau_s=(1.5, 4.0)),
    _sag("hyperbolic", sag_hyperbolic, 1e-3, 0.6),
    _sag("branch_and_line", sag_thevenin, 1e-3, 0.6, tau_s=(0.8, 2.5)),
    _sag("load", sag_load_dependent, 1e-3, 0.6),
    _servo("first_order", servo_first_order, 1e-3, 1, tau_s=(0.15, 0.5)),
    _servo("underdamped", servo_underdamped, 1e-3, 1, tau_s=(0.15, 0.4)),
    _servo("rate_limit", servo_rate_limited, 1e-3, 1, tau_s=(0.15, 0.5)),
    _servo("dead_time", servo_dead_time, 1e-3, 1, tau_s=(0.1, 0.3), dead_s=(0.1, 0.4)),
    _sink("linear", sinking_linear, 1e-3, 0.16),
    _sink("square", sinking_quadratic, 1e-3, 0.16),
    _sink("saturating", sinking_saturating, 1e-3, 0.12, tau_s=(1.5, 4.0)),
)


def offset_constant(t: Array, phi: Array, s: Array, p: ShapeParameters) -> tuple[Array, Array]:
    """The horn is mounted s beside its mark, rad."""
    return phi + s, 0 * phi


def offset_backlash(t: Array, phi: Array, s: Array, p: ShapeParameters) -> tuple[Array, Array]:
    """The flow pushes the head to one end of the play: phi + s sign(phi)."""
    return phi + s * np.tanh(phi / np.deg2rad(4)), 0 * phi


def offset_gain(t: Array, phi: Array, s: Array, p: ShapeParameters) -> tuple[Array, Array]:
    """Wrong scale of the command, phi + s phi/45 deg."""
    return phi + s * phi / (np.pi / 4), 0 * phi


_offset = form_maker("head_angle_offset", "servo", "rad", ("sway", "yaw"), signed=True)
FORMS += (
    _offset("constant", offset_constant, 1e-3, 0.2),
    _offset("backlash", offset_backlash, 1e-3, 0.2),
    _offset("gain", offset_gain, 1e-3, 0.3),
)
