"""The maker's own laws of what a simple model leaves out, chosen by name and strength.

A law of `drive` changes what the motor and servo do, of `current` moves the water, of `load`
adds a force and a yaw moment, of `gain` scales the thrust or the lift.  They are written in
forms of their own, not those of the candidates that the analysis tries.
"""

import cmath
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from bluekoi.errors import input_error, nearest

__all__ = [
    "LAWS",
    "Drive",
    "Law",
    "Situation",
    "change_drive",
    "check_hidden",
    "extra_current",
    "extra_load",
]

Chosen = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class Drive:
    """What motor and servo do: beat frequency (Hz), head angle (rad), factor on the thrust."""

    flap_hz: float
    head_angle_rad: float
    thrust_gain: float = 1.0


@dataclass(frozen=True)
class Situation:
    """What a law of force may depend on: SI units, velocity relative to the water (x + i y)."""

    time_s: float
    place: complex
    psi: float
    theta: float
    velocity: complex
    yaw_rate: float
    plate_area_m2: float
    arm_m: float
    drive: Drive
    pool_m: tuple[float, float]
    density_kg_m3: float = 1000.0
    thrust_gain: float = 1.0
    lift_gain: float = 1.0


@dataclass(frozen=True)
class Law:
    """One hidden effect: where it acts, its statement, its parameters with their usual size."""

    acts_on: str
    statement: str
    usual: Mapping[str, float]
    law: Callable[..., Any]


def linear_yaw_damping(now: Situation, *, N_r: float) -> tuple[complex, float]:
    """Moment `-N_r r` (N m; N_r in N m s)."""
    return 0j, -N_r * now.yaw_rate


def viscous_drag(now: Situation, *, k: float) -> tuple[complex, float]:
    """Drag `-k |v|^1.5` (N; k in N (s/m)^1.5), as of a laminar boundary layer."""
    return -k * now.velocity * math.sqrt(abs(now.velocity)), 0.0


def wall_effect(now: Situation, *, k: float, reach_m: float) -> tuple[complex, float]:
    """Drag `-k |v| v exp(-gap/reach)` (N; k in kg/m) that grows towards the nearest wall."""
    length, width = now.pool_m
    x, y = now.place.real, now.place.imag
    gap = max(min(x, length - x, y, width - y), 0.0)
    return -k * math.exp(-gap / reach_m) * abs(now.velocity) * now.velocity, 0.0


def trim_moment(now: Situation, *, k: float) -> tuple[complex, float]:
    """Moment `k |v|^2` (N m; k in kg): the body is not quite straight."""
    return 0j, k * abs(now.velocity) ** 2


def crossflow_drag(now: Situation, *, k: float, arm_m: float) -> tuple[complex, float]:
    """Sideways drag `-k w |w|` (N; k in kg/m) of core and tail, at `arm` behind the centre."""
    axis = cmath.exp(1j * now.psi)
    sideways = (now.velocity * axis.conjugate()).imag - arm_m * now.yaw_rate
    force = -k * sideways * abs(sideways)
    return force * 1j * axis, -arm_m * force


def thrust_loss_with_speed(now: Situation, *, advance_m: float) -> Situation:
    """Thrust times `exp(-u / (f advance))`: the tail finds less slip as the robot speeds up."""
    along = (now.velocity * cmath.exp(-1j * now.psi)).real
    slip = math.exp(-max(along, 0.0) / (max(now.drive.flap_hz, 1e-6) * advance_m))
    return replace(now, thrust_gain=now.thrust_gain * slip)


def stall(now: Situation, *, onset_rad: float, width_rad: float) -> Situation:
    """Lift times `1/(1 + exp((|alpha| - onset)/width))` on the head plate."""
    if now.velocity == 0:
        return now
    alpha = cmath.phase(cmath.exp(1j * now.theta) / now.velocity)
    kept = 1 / (1 + math.exp((abs(alpha) - onset_rad) / width_rad))
    return replace(now, lift_gain=now.lift_gain * kept)


def servo_lag(time_s: float, drive: Drive, *, time_constant_s: float) -> Drive:
    """Head angle reached as `1 - (1 + t/T) exp(-t/T)`: a critically damped second-order servo."""
    x = max(time_s, 0.0) / time_constant_s
    return replace(drive, head_angle_rad=drive.head_angle_rad * (1 - (1 + x) * math.exp(-x)))


def head_angle_offset(_time_s: float, drive: Drive, *, offset_rad: float) -> Drive:
    """Head angle short or over by a constant (rad)."""
    return replace(drive, head_angle_rad=drive.head_angle_rad + offset_rad)


def motor_spin_up(time_s: float, drive: Drive, *, time_constant_s: float) -> Drive:
    """Frequency `f tanh(t/T)`."""
    return replace(drive, flap_hz=drive.flap_hz * math.tanh(max(time_s, 0.0) / time_constant_s))


def battery_sag(time_s: float, drive: Drive, *, loss_per_s: float) -> Drive:
    """Thrust factor `1/(1 + loss t)`: the pack sags while the frequency is held."""
    return replace(drive, thrust_gain=drive.thrust_gain / (1 + loss_per_s * max(time_s, 0.0)))


def uniform_current(_time_s: float, _place: complex, *, u_m_s: float, v_m_s: float) -> complex:
    """The same water velocity everywhere (m/s)."""
    return complex(u_m_s, v_m_s)


def pool_gyre(_time_s: float, place: complex, *, rate_rad_s: float, core_m: float) -> complex:
    """Gaussian vortex about the pool's middle: `i w z exp(-|z|^2 / core^2)`."""
    z = place - complex(1.3, 0.8)
    return 1j * rate_rad_s * z * math.exp(-(abs(z) ** 2) / core_m**2)


LAWS: Mapping[str, Law] = {
    "linear_yaw_damping": Law(
        "load", "a yaw moment against the yaw rate", {"N_r": 0.02}, linear_yaw_damping
    ),
    "viscous_drag": Law("load", "drag that grows as v^1.5", {"k": 0.6}, viscous_drag),
    "wall_effect": Law("load", "more drag near a wall", {"k": 4.0, "reach_m": 0.12}, wall_effect),
    "trim_moment": Law("load", "a moment on a straight robot", {"k": 0.02}, trim_moment),
    "crossflow_drag": Law(
        "load", "sideways drag of core and tail", {"k": 4.0, "arm_m": 0.08}, crossflow_drag
    ),
    "thrust_loss_with_speed": Law(
        "gain", "thrust falls with speed", {"advance_m": 0.4}, thrust_loss_with_speed
    ),
    "stall": Law(
        "gain", "lift is lost at large angles", {"onset_rad": 0.5, "width_rad": 0.06}, stall
    ),
    "servo_lag": Law("drive", "the head arrives late", {"time_constant_s": 0.3}, servo_lag),
    "head_angle_offset": Law(
        "drive", "the head angle is off by a constant", {"offset_rad": 0.05}, head_angle_offset
    ),
    "motor_spin_up": Law(
        "drive", "the motor starts slowly", {"time_constant_s": 0.4}, motor_spin_up
    ),
    "battery_sag": Law("drive", "thrust sinks with time", {"loss_per_s": 0.05}, battery_sag),
    "uniform_current": Law(
        "current", "the water drifts", {"u_m_s": 0.012, "v_m_s": -0.006}, uniform_current
    ),
    "pool_gyre": Law(
        "current", "the water circles", {"rate_rad_s": 0.04, "core_m": 0.6}, pool_gyre
    ),
}


def check_hidden(chosen: Chosen) -> None:
    """Nothing; raises `InputError` for a name or a parameter that no law has."""
    for name, values in chosen.items():
        if name not in LAWS:
            raise input_error("hidden effects", name, name, "a known effect", nearest(name, LAWS))
        if set(values) != set(LAWS[name].usual):
            wanted = ", ".join(LAWS[name].usual)
            raise input_error("hidden effects", name, ", ".join(values), wanted)


def _acting(chosen: Chosen, on: str) -> list[tuple[Callable[..., Any], Mapping[str, float]]]:
    return [(LAWS[name].law, values) for name, values in chosen.items() if LAWS[name].acts_on == on]


def change_drive(chosen: Chosen, time_s: float, drive: Drive) -> Drive:
    """The drive after every chosen law of motor and servo."""
    for law, values in _acting(chosen, "drive"):
        drive = law(time_s, drive, **values)
    return drive


def extra_current(chosen: Chosen, time_s: float, place: complex) -> complex:
    """Water velocity (m/s) of every chosen law of the water."""
    return sum((law(time_s, place, **v) for law, v in _acting(chosen, "current")), 0j)


def extra_load(chosen: Chosen, now: Situation) -> tuple[complex, float, Situation]:
    """Force (N), moment (N m) of the chosen laws, and the situation with gains applied."""
    force, moment = 0j, 0.0
    for law, values in _acting(chosen, "load"):
        more_force, more_moment = law(now, **values)
        force, moment = force + more_force, moment + more_moment
    for law, values in _acting(chosen, "gain"):
        now = law(now, **values)
    return force, moment, now
