"""Laws of motor, servo and thrust.

Hooks: `flap` factor on the frequency, `servo` head angle (rad), `thrust` factor on the thrust,
`force` loads on the body (force in N in axes of the core, moment in N m).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .form import Family, Flow, reference
from .robots import Array, Robot

HORIZON = 8.0
"""Time (s) over which sag and sinking reach their size."""


def spin_first(t: float, _load: Array, size: float, _shape: float) -> Any:
    """1 - exp(-t / size)."""
    return 1 - np.exp(-t / size)


def spin_second(t: float, _load: Array, size: float, _shape: float) -> Any:
    """Critically damped: 1 - (1 + t/s) exp(-t/s), s = size / 2."""
    return 1 - (1 + 2 * t / size) * np.exp(-2 * t / size)


def spin_ramp(t: float, _load: Array, size: float, shape: float) -> Any:
    """S-curve of the speed controller over 2 size, after a small step."""
    x = np.clip(t / (2 * size), 0, 1)
    return 0.3 * shape + (1 - 0.3 * shape) * x * x * (3 - 2 * x)


def sag_linear(t: float, _load: Array, size: float, _shape: float) -> Any:
    """1 - size t / horizon."""
    return 1 - size * t / HORIZON


def sag_hyperbolic(t: float, load: Array, size: float, _shape: float) -> Any:
    """1 / (1 + size load t / horizon): charge drawn; W. Peukert, Elektrot. Z. 20 (1897) 287."""
    return 1 / (1 + size * (0.4 + 0.6 * load) * t / HORIZON)


def sag_cell(t: float, load: Array, size: float, shape: float) -> Any:
    """Load times (RC step and slope): M. Chen, G. A. Rincon-Mora, IEEE Trans. EC 21 (2006) 504."""
    step = 1 - np.exp(-t / (0.8 + 1.5 * shape))
    return 1 - size * load * (0.5 * step + 0.5 * t / HORIZON)


def servo_first(t: float, phi: Array, size: float, _shape: float) -> Array:
    """Phi (1 - exp(-t / size)), from a straight head."""
    return phi * (1 - np.exp(-t / size))


def servo_second(t: float, phi: Array, size: float, shape: float) -> Array:
    """Underdamped second order with damping 0.4 to 0.7 and time size."""
    zeta = 0.4 + 0.3 * shape
    root = np.sqrt(1 - zeta**2)
    x = t / size
    decay = np.exp(-zeta * x) * (np.cos(root * x) + zeta / root * np.sin(root * x))
    return phi * (1 - decay)


def servo_rate(t: float, phi: Array, size: float, _shape: float) -> Array:
    """Constant rate: 30 degrees in a time of size."""
    return np.clip(phi, -np.radians(30) * t / size, np.radians(30) * t / size)


def offset_constant(_t: float, phi: Array, size: float, _shape: float) -> Array:
    """Linkage mounted off by size."""
    return phi + size


def offset_gain(_t: float, phi: Array, size: float, _shape: float) -> Array:
    """Horn of wrong length: the angle is off by size at 30 degrees, and by size/5 when straight."""
    return phi + size * (0.2 + 0.8 * phi / np.radians(30))


def offset_backlash(_t: float, phi: Array, size: float, _shape: float) -> Array:
    """Backlash: the flow pushes the head back by size, and to one side when it is straight."""
    return phi - size * np.where(phi == 0, 1, np.sign(phi))


def _advance(flow: Flow, robot: Robot) -> Array:
    """(u / f) / (V0 / f100): advance per beat, 1 in a straight run of the published model."""
    return np.maximum(flow.v.real, 0) / flow.flap.clip(0.05) * robot.flap / robot.speed


def loss_linear(flow: Flow, robot: Robot, size: float, _shape: float) -> Array:
    """1 - size J: a propeller's thrust line."""
    return np.maximum(1 - size * _advance(flow, robot), 0)


def loss_lighthill(flow: Flow, robot: Robot, size: float, _shape: float) -> Array:
    """1 - size J^2: (1 - U^2/c^2) of an elongated body; M. J. Lighthill, JFM 9 (1960) 305."""
    return np.maximum(1 - size * _advance(flow, robot) ** 2, 0)


def loss_intake(flow: Flow, robot: Robot, size: float, shape: float) -> Array:
    """1 / (1 + size J^p), p = 1 to 2: momentum theory with a slipstream."""
    return 1 / (1 + size * _advance(flow, robot) ** (1 + shape))


def area_power(flow: Flow, robot: Robot, size: float, _shape: float) -> Array:
    """(A0 / A)^size: size 1 means thrust that knows nothing of the head."""
    return (robot.head_length / flow.head) ** size


def area_blend(flow: Flow, robot: Robot, size: float, _shape: float) -> Array:
    """1 + size (A0 / A - 1): a part of the thrust belongs to the tail alone."""
    return 1 + size * (robot.head_length / flow.head - 1)


def wake_logistic(flow: Flow, _robot: Robot, size: float, shape: float) -> Array:
    """Thrust lost once the robot has turned about 0.6 to 0.8 of a circle."""
    turns = np.abs(flow.turned) / (2 * np.pi)
    return 1 - size / (1 + np.exp(-(turns - 0.6 - 0.2 * shape) / 0.06))


def wake_ramp(flow: Flow, _robot: Robot, size: float, _shape: float) -> Array:
    """Loss that grows between 0.4 and 0.9 of a circle."""
    return 1 - size * np.clip((np.abs(flow.turned) / (2 * np.pi) - 0.4) / 0.5, 0, 1)


def wake_aged(flow: Flow, robot: Robot, size: float, _shape: float) -> Array:
    """As `wake_logistic`, less in an old wake (decay with the inverse age of the circle)."""
    age = 2 * np.pi / np.maximum(np.abs(flow.r), 0.05) * robot.speed / robot.body_length
    return 1 - (1 - wake_logistic(flow, robot, size, 0.5)) * np.minimum(1, 12 / age)


def _sink(share: float, flow: Flow, robot: Robot, size: float) -> tuple[Array, float]:
    """Drag of a body that swims pitched while it sinks."""
    return size * share * robot.drag * reference(flow, robot) ** 2 * flow.backward, 0.0


def sink_share(t: Any, form: str) -> Any:
    """Depth gained at time t over that at the horizon."""
    if form == "settling":
        return 1 - np.exp(-t / 3.0)
    return (t / HORIZON) ** (2 if form == "flooding" else 1)


def sink_steady(flow: Flow, robot: Robot, size: float, _shape: float) -> tuple[Array, float]:
    """Depth grows with time."""
    return _sink(sink_share(flow.t, "steady"), flow, robot, size)


def sink_flooding(flow: Flow, robot: Robot, size: float, _shape: float) -> tuple[Array, float]:
    """A hull that takes water: depth grows with the square of time."""
    return _sink(sink_share(flow.t, "flooding"), flow, robot, size)


def sink_settling(flow: Flow, robot: Robot, size: float, _shape: float) -> tuple[Array, float]:
    """Depth tends to a new one."""
    return _sink(sink_share(flow.t, "settling"), flow, robot, size)


def _trim(flow: Flow, robot: Robot, level: Array) -> tuple[Array, Array]:
    return 0j * flow.v, 0.2 * robot.drag * robot.body_length * level


def trim_speed(flow: Flow, robot: Robot, size: float, _shape: float) -> tuple[Array, Array]:
    """Moment as V^2: a bent body."""
    return _trim(flow, robot, size * reference(flow, robot) ** 2)


def trim_thrust(flow: Flow, robot: Robot, size: float, _shape: float) -> tuple[Array, Array]:
    """Moment as the thrust: a beat with unequal halves."""
    return _trim(flow, robot, size * flow.thrust / robot.drag)


def trim_forward(flow: Flow, robot: Robot, size: float, _shape: float) -> tuple[Array, Array]:
    """Moment as u |u|: a bent tail."""
    u = flow.v.real / robot.speed
    return _trim(flow, robot, size * u * np.abs(u))


def line_sine(flow: Flow, robot: Robot, size: float, _shape: float) -> tuple[Array, Array]:
    """Moment T e sin phi, e = size times body length."""
    return 0j * flow.v, flow.thrust * size * robot.body_length * np.sin(flow.phi)


def line_angle(flow: Flow, robot: Robot, size: float, _shape: float) -> tuple[Array, Array]:
    """Moment T e phi."""
    return 0j * flow.v, flow.thrust * size * robot.body_length * flow.phi


def line_double(flow: Flow, robot: Robot, size: float, _shape: float) -> tuple[Array, Array]:
    """Moment T e sin(2 phi) / 2."""
    return 0j * flow.v, flow.thrust * size * robot.body_length * 0.5 * np.sin(2 * flow.phi)


FAMILIES = (
    Family("motor_spin_up", "flap", "time", "s", 0.08, 2.5,
           {"first": spin_first, "second": spin_second, "ramp": spin_ramp}),
    Family("battery_sag", "flap", "share_of_frequency", "1", 0.02, 0.45,
           {"linear": sag_linear, "hyperbolic": sag_hyperbolic, "cell": sag_cell}),
    Family("servo_lag", "servo", "time", "s", 0.04, 2.0,
           {"first": servo_first, "second": servo_second, "rate": servo_rate}),
    Family("head_angle_offset", "servo", "angle", "rad", 0.01, 0.2,
           {"constant": offset_constant, "gain": offset_gain, "backlash": offset_backlash},
           odd=True),
    Family("thrust_loss_with_speed", "thrust", "share_of_thrust", "1", 0.05, 0.85,
           {"linear": loss_linear, "lighthill": loss_lighthill, "intake": loss_intake}),
    Family("thrust_area", "thrust", "exponent", "1", 0.1, 1.0,
           {"power": area_power, "blend": area_blend}),
    Family("wake_reentry", "thrust", "share_of_thrust", "1", 0.05, 0.7,
           {"logistic": wake_logistic, "ramp": wake_ramp, "aged": wake_aged}),
    Family("sinking", "force", "share_of_drag", "1", 0.05, 1.5,
           {"steady": sink_steady, "flooding": sink_flooding, "settling": sink_settling}),
    Family("trim_moment", "force", "share_of_moment", "1", 0.01, 1.0,
           {"speed": trim_speed, "thrust": trim_thrust, "forward": trim_forward}, odd=True),
    Family("thrust_line_offset", "force", "share_of_body_length", "1", 0.01, 0.4,
           {"sine": line_sine, "angle": line_angle, "double": line_double}, odd=True),
)  # fmt: skip
