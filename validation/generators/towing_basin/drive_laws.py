"""Hidden laws of motor, thrust and servo: factors on frequency and thrust, head angles in time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .form import Array, Form, InstantaneousState, ParallelTrials

ShapeParameters = Mapping[str, float]
ADVANCE_LENGTH_M = 0.1
"""Length by which speeds are referred to the beat, J = u / (f d), m."""


def _advance_ratio(m: InstantaneousState) -> Array:
    return np.maximum(m.flow.real, 0) / (m.hertz * ADVANCE_LENGTH_M)


def thrust_loss_linear(m: InstantaneousState, s: float, _: ShapeParameters) -> Array:
    """1 - s J: thrust of a screw falls about linearly (Carlton 2012, Marine Propellers, ch. 6)."""
    return 1 - s * _advance_ratio(m)


def thrust_loss_quadratic(m: InstantaneousState, s: float, _: ShapeParameters) -> Array:
    """1 - s J^2: first even term of the thrust curve (Carlton 2012, ch. 6)."""
    return 1 - s * _advance_ratio(m) ** 2


def thrust_loss_exponential(m: InstantaneousState, s: float, _: ShapeParameters) -> Array:
    """exp(-s J): a smooth loss that never turns thrust into drag."""
    return np.exp(-s * _advance_ratio(m))


def thrust_loss_strouhal(m: InstantaneousState, s: float, p: ShapeParameters) -> Array:
    """1 - s (1 - exp(-((St - St_0)/w)^2)), St = 1/J: efficient window, Triantafyllou 1993."""
    strouhal = 1 / np.maximum(_advance_ratio(m), 0.15)
    return 1 - s * (1 - np.exp(-(((strouhal - p["peak"]) / p["width"]) ** 2)))


def thrust_area_power(m: InstantaneousState, s: float, _: ShapeParameters) -> Array:
    """(A / A_1)^-s: thrust grows slower than the head's area."""
    return (m.lanes.head / 0.12) ** -s


def thrust_area_share(m: InstantaneousState, s: float, _: ShapeParameters) -> Array:
    """1 - s + s A_1 / A: a share of the thrust does not know the head."""
    return 1 - s + s * 0.12 / m.lanes.head


def thrust_area_logarithmic(m: InstantaneousState, s: float, _: ShapeParameters) -> Array:
    """1 - s ln(A / A_1)."""
    return 1 - s * np.log(m.lanes.head / 0.12)


def wake_logistic(m: InstantaneousState, s: float, p: ShapeParameters) -> Array:
    """Thrust falls by s as the robot closes its circle and meets its own wake; a logistic step."""
    return 1 - s / (1 + np.exp(-(np.abs(m.turned) - p["onset"]) / 0.3))


def wake_ramp(m: InstantaneousState, s: float, p: ShapeParameters) -> Array:
    """Thrust falls by s for each turn after the onset, up to two turns."""
    return 1 - s * np.clip((np.abs(m.turned) - p["onset"]) / (2 * np.pi), 0, 2)


def wake_saturating(m: InstantaneousState, s: float, p: ShapeParameters) -> Array:
    """1 - s (1 - exp(-x)), x turns after the onset."""
    return 1 - s * (1 - np.exp(-np.maximum(np.abs(m.turned) - p["onset"], 0) / 2))


def sag_linear(t: Array, _: ParallelTrials, s: float, __: ShapeParameters) -> Array:
    """1 - s t / 10 s: falling voltage of a cell in its flat region."""
    return 1 - s * t / 10


def sag_exponential(t: Array, _: ParallelTrials, s: float, p: ShapeParameters) -> Array:
    """1 - s (1 - exp(-t / tau)): relaxation of the cell (Chen and Rincon-Mora 2006)."""
    return 1 - s * (1 - np.exp(-t / p["tau"]))


def sag_hyperbolic(t: Array, _: ParallelTrials, s: float, p: ShapeParameters) -> Array:
    """1 / (1 + s t / tau): Shepherd 1965, the term in remaining capacity."""
    return 1 / (1 + s * t / p["tau"])


def sag_load_dependent(t: Array, lanes: ParallelTrials, s: float, _: ShapeParameters) -> Array:
    """1 - s (f / 5 Hz)^2 t / 10 s: the sag grows with the load."""
    return 1 - s * (lanes.hertz / 5) ** 2 * t / 10


def spin_up_first_order(t: Array, _: ParallelTrials, s: float, __: ShapeParameters) -> Array:
    """1 - exp(-t / s): motor with rotor inertia."""
    return 1 - np.exp(-t / s)


def spin_up_critically_damped(t: Array, _: ParallelTrials, s: float, __: ShapeParameters) -> Array:
    """1 - (1 + t/s) exp(-t/s): rotor and compliant drive, critically damped."""
    return 1 - (1 + t / s) * np.exp(-t / s)


def spin_up_ramp(t: Array, _: ParallelTrials, s: float, __: ShapeParameters) -> Array:
    """min(t / 2s, 1): speed controller with a limited slope."""
    return np.minimum(t / (2 * s), 1)


def spin_up_s_curve(t: Array, _: ParallelTrials, s: float, __: ShapeParameters) -> Array:
    """Cubic step 3 x^2 - 2 x^3 over 2 s seconds: jerk-limited controller."""
    x = np.clip(t / (2 * s), 0, 1)
    return x * x * (3 - 2 * x)


def servo_first_order(t: Array, angle: Array, s: float, _: ShapeParameters) -> Array:
    """Phi (1 - exp(-t/s))."""
    return angle * (1 - np.exp(-t / s))


def servo_underdamped(t: Array, angle: Array, s: float, p: ShapeParameters) -> Array:
    """Step response of second order, natural frequency 1/s and damping ratio below one."""
    zeta, x = p["damping"], t / s
    root = np.sqrt(1 - zeta**2)
    return angle * (1 - np.exp(-zeta * x) * (np.cos(root * x) + zeta / root * np.sin(root * x)))


def servo_rate_limited(t: Array, angle: Array, s: float, _: ShapeParameters) -> Array:
    """Turns at a limited rate of 0.5 rad per s seconds."""
    return np.sign(angle) * np.minimum(np.abs(angle), 0.5 * t / s)


def servo_dead_time(t: Array, angle: Array, s: float, _: ShapeParameters) -> Array:
    """Straight for s seconds, then an exponential of the same time."""
    return angle * (1 - np.exp(-np.maximum(t - s, 0) / s))


def offset_constant(_: Array, angle: Array, s: float, __: ShapeParameters) -> Array:
    """Phi + s: the horn sits a tooth off."""
    return angle + s


def offset_gain(_: Array, angle: Array, s: float, __: ShapeParameters) -> Array:
    """(1 + s) phi: linkage with a wrong ratio."""
    return angle * (1 + s)


def offset_backlash(_: Array, angle: Array, s: float, p: ShapeParameters) -> Array:
    """Phi - s tanh(phi / w): play of the hinge, taken up by the load; and slack to one side."""
    return angle - s * np.tanh(angle / p["width"]) - 0.5 * s


def _loss(name: str, law: object, start: float, limit: float, **shape: tuple[float, float]) -> Form:
    return Form("thrust_loss_with_speed", name, "thrust", law, ("surge",), "speed_m_s", "1",
                start, limit, shape)  # fmt: skip


def _wake(name: str, law: object) -> Form:
    return Form("wake_reentry", name, "thrust", law, ("surge",), "turned_angle_rad", "1", 0.1, 0.6,
                {"onset": (3.5, 6.3)})  # fmt: skip


def _area(name: str, law: object) -> Form:
    return Form("thrust_area", name, "thrust", law, ("surge",), "head_length_m", "1", 0.2, 1.0)


def _sag(name: str, law: object, limit: float, **shape: tuple[float, float]) -> Form:
    return Form("battery_sag", name, "frequency", law, ("surge",), "time_s", "1", 0.08, limit,
                shape)  # fmt: skip


def _spin(name: str, law: object) -> Form:
    return Form("motor_spin_up", name, "frequency", law, ("surge",), "time_s", "s", 0.15, 1.5)


def _servo(name: str, law: object, **shape: tuple[float, float]) -> Form:
    return Form("servo_lag", name, "angle", law, ("sway", "yaw"), "time_s", "s", 0.15, 1.2, shape)


def _offset(name: str, law: object, unit: str, limit: float, **shape: tuple[float, float]) -> Form:
    return Form("head_angle_offset", name, "angle", law, ("sway", "yaw"), "head_angle_rad", unit,
                0.04, limit, shape, odd=name != "gain")  # fmt: skip


FORMS = (
    _loss("linear", thrust_loss_linear, 0.1, 0.6),
    _loss("quadratic", thrust_loss_quadratic, 0.1, 0.6),
    _loss("exponential", thrust_loss_exponential, 0.1, 1.5),
    _loss("strouhal", thrust_loss_strouhal, 0.2, 0.8, peak=(0.7, 1.0), width=(0.4, 1.2)),
    _area("power", thrust_area_power),
    _area("share", thrust_area_share),
    _area("log", thrust_area_logarithmic),
    _wake("logistic", wake_logistic),
    _wake("ramp", wake_ramp),
    _wake("saturating", wake_saturating),
    _sag("linear", sag_linear, 0.4),
    _sag("exponential", sag_exponential, 0.4, tau=(1.5, 5.0)),
    _sag("hyperbolic", sag_hyperbolic, 0.6, tau=(6.0, 12.0)),
    _sag("loaded", sag_load_dependent, 0.3),
    _spin("first_order", spin_up_first_order),
    _spin("second_order", spin_up_critically_damped),
    _spin("ramp", spin_up_ramp),
    _spin("s_curve", spin_up_s_curve),
    _servo("first_order", servo_first_order),
    _servo("underdamped", servo_underdamped, damping=(0.3, 0.7)),
    _servo("rate_limit", servo_rate_limited),
    _servo("dead_time", servo_dead_time),
    _offset("constant", offset_constant, "rad", 0.25),
    _offset("gain", offset_gain, "1", 0.4),
    _offset("backlash", offset_backlash, "rad", 0.25, width=(0.05, 0.2)),
)
