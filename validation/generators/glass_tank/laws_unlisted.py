"""Forces that no named cause describes; each depends on one variable."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .form import UNLISTED, Array, Cause, Family, Quantity, Shape, Situation
from .robots import Robot


@dataclass(frozen=True)
class UnlistedForce:
    """An unlisted force: what it depends on and how strong it may be.

    span: plausible strengths in units of `scale`(robot). pool_fixed: tied to the pool's axes.
    """

    variable: str
    unit: str
    channel: str
    span: tuple[float, float]
    scale: Callable[[Robot], float]
    pool_fixed: bool = False


FORCES = {
    "tether_pull": UnlistedForce(
        "position", "N/m", "surge", (0.01, 0.3), lambda b: b.top_thrust / b.body_length / 5, True
    ),
    "compass_torque": UnlistedForce(
        "heading", "N m", "yaw", (0.002, 0.1), lambda b: b.top_thrust * b.body_length, True
    ),
    "tail_resonance": UnlistedForce(
        "flapping frequency", "N", "surge", (0.02, 0.5), lambda b: b.top_thrust
    ),
    "spin_drag": UnlistedForce(
        "yaw rate", "N s", "surge", (0.02, 0.6), lambda b: b.top_thrust / b.reference_yaw_rate
    ),
    "pump_pulse": UnlistedForce("time", "N", "surge", (0.004, 0.25), lambda b: b.top_thrust),
    "hinge_gap_drag": UnlistedForce(
        "head angle", "N", "surge", (0.02, 0.4), lambda b: b.top_thrust
    ),
    "sideslip_brake": UnlistedForce(
        "sway speed", "N s/m", "surge", (0.05, 1.2), lambda b: b.top_thrust / b.top_speed
    ),
}


def _forward(now: Situation) -> Array:
    """Sign of the forward speed, smooth."""
    return np.tanh(now.u / (0.05 * now.robot.top_speed))


def _unlisted(now: Situation, strength: Quantity, cause: Cause) -> None:
    """An elastic line to a post; a magnet in the hull; loss where the tail resonates.

    Drag of the turning hull; a pump of unsteady flow; an open hinge; plates that open with the
    sideways speed.
    """
    form, shape, axis, forward = cause.form, cause.shape, now.axis, _forward(now)
    if form == "tether_pull":
        post = complex(shape["x_m"], shape["y_m"])
        now.force = now.force - strength * (now.x + 1j * now.y - post)
    elif form == "compass_torque":
        now.moment = now.moment - strength * np.sin(now.psi - shape["north_rad"])
    elif form == "tail_resonance":
        near = np.exp(-(((now.flap - shape["f_hz"]) / shape["width_hz"]) ** 2))
        now.force = now.force - strength * near * axis * (now.flap > 0)
    elif form == "spin_drag":
        now.force = now.force - strength * np.abs(now.r) * axis * forward
    elif form == "pump_pulse":
        pulse = np.sin(2 * np.pi * now.t / shape["period_s"])
        now.force = now.force + strength * pulse * axis * (now.flap > 0)
    elif form == "hinge_gap_drag":
        now.force = now.force - strength * np.sin(now.phi) ** 2 * axis * forward
    elif form == "sideslip_brake":
        now.force = now.force - strength * np.abs(now.w) * axis * forward


def draw_shape(rng: np.random.Generator, robot: Robot, form: str) -> Shape:
    """Shape parameters of an unlisted force."""
    length, width = robot.pool
    if form == "tether_pull":
        return {
            "x_m": round(length * rng.uniform(0.3, 0.7), 3),
            "y_m": round(width * rng.uniform(0.3, 0.7), 3),
        }
    if form == "compass_torque":
        return {"north_rad": round(rng.uniform(-np.pi, np.pi), 3)}
    if form == "tail_resonance":
        return {
            "f_hz": round(robot.top_flap * rng.uniform(0.65, 0.8), 3),
            "width_hz": round(robot.top_flap * rng.uniform(0.07, 0.12), 3),
        }
    return {"period_s": round(rng.uniform(2.0, 5.0), 2)} if form == "pump_pulse" else {}


def unlisted_family(form: str, robot: Robot) -> Family:
    """The unlisted force as a family of its own, outside the catalogue."""
    force = FORCES[form]
    unit = force.scale(robot)
    return Family(
        "unlisted",
        {"load": _unlisted},
        (form,),
        channels=(force.channel,),
        variable=force.variable,
        unit=force.unit,
        scale="1",
        span=(force.span[0] * unit, force.span[1] * unit),
        kind=UNLISTED,
        parity="pool" if force.pool_fixed else "even",
        draw=draw_shape,
    )
